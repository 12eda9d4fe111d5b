// Half-balls of radius 8 below and above the plane z = 0, about the middle of the contact, whose radius is 1. Each is meshed for
// itself, so that nodes do not match: edges of 1/10 and 1/8 where they touch, growing outwards. Discs of radius 1.1 may touch.
// gmsh balls.geo -3 -o balls.msh
SetFactory("OpenCASCADE");
L = 8;
e = 1e-3;
Sphere(1) = {0, 0, 0, L, -Pi/2, 0};
Sphere(2) = {0, 0, 0, L, 0, Pi/2};
Disk(100) = {0, 0, 0, 1.1};
BooleanFragments{ Volume{1}; Delete; }{ Surface{100}; Delete; }
Disk(200) = {0, 0, 0, 1.1};
BooleanFragments{ Volume{2}; Delete; }{ Surface{200}; Delete; }
discs() = Surface In BoundingBox {-1.1 - e, -1.1 - e, -e, 1.1 + e, 1.1 + e, e};
flats() = Surface In BoundingBox {-L - e, -L - e, -e, L + e, L + e, e};
For v In {1:2}
  h = (v == 1) ? 1/10 : 1/8;
  all() = Abs(Boundary{ Volume{v}; });
  cut() = all();
  cut() -= flats();
  touch() = {};
  For i In {0:#discs()-1}
    For j In {0:#all()-1}
      If (all(j) == discs(i))
        touch() += discs(i);
      EndIf
    EndFor
  EndFor
  If (v == 1)
    Physical Volume("lower") = {v};
    Physical Surface("lower_contact") = touch();
    Physical Surface("lower_cut") = cut();
  Else
    Physical Volume("upper") = {v};
    Physical Surface("upper_contact") = touch();
    Physical Surface("upper_cut") = cut();
  EndIf
  Field[2*v] = MathEval;
  Field[2*v].F = Sprintf("%g + 0.5*Max(0, sqrt(x*x + y*y) - 1.1) + 0.5*abs(z)", h);
  Field[2*v+1] = Restrict;
  Field[2*v+1].InField = 2*v;
  Field[2*v+1].VolumesList = {v};
  Field[2*v+1].IncludeBoundary = 1;
EndFor
Field[6] = Min;
Field[6].FieldsList = {3, 5};
Background Field = 6;
Mesh.MeshSizeExtendFromBoundary = 0;
Mesh.MeshSizeFromPoints = 0;
Mesh.MeshSizeFromCurvature = 0;
Mesh.ElementOrder = 2;
Mesh.HighOrderOptimize = 2;
Mesh.Optimize = 1;
Mesh.OptimizeNetgen = 1;
Mesh.MshFileVersion = 2.2;
Mesh.Binary = 1;
