// A twelfth of a pair of flanges with six bolts: from the plane through a bolt (y = 0) to the plane between two (30 degrees).
// Rings 50 < r < 100, 20 thick; bolt circle at the radius of the middle of force of a uniform traction,
// 2/3 (100^3 - 50^3)/(100^2 - 50^2); holes of 18, shank of 16, round heads of 26 and 10 high.
// gmsh flange.geo -3 -o flange.msh
SetFactory("OpenCASCADE");
Mesh.ElementOrder = 2;
Mesh.HighOrderOptimize = 0;
Mesh.MshFileVersion = 4.1;
Mesh.Algorithm3D = 1;

a = 50; b = 100; t = 20; rb = 2/3*(b^3 - a^3)/(b^2 - a^2);
hole = 9; shank = 8; head = 13; high = 10; angle = Pi/6;
planes0() = {}; planes30() = {}; joints() = {}; seats() = {}; outsides() = {}; bores() = {};
middle() = {}; under_head() = {}; under_nut() = {};

Cylinder(1) = {0, 0, 0, 0, 0, t, b, angle};
Cylinder(2) = {0, 0, 0, 0, 0, t, a, angle};
Cylinder(3) = {rb, 0, 0, 0, 0, t, hole};
BooleanDifference(4) = { Volume{1}; Delete; }{ Volume{2, 3}; Delete; };
Disk(1000) = {rb, 0, t, head};
upper() = BooleanFragments{ Volume{4}; Delete; }{ Surface{1000}; Delete; };

Cylinder(11) = {0, 0, -t, 0, 0, t, b, angle};
Cylinder(12) = {0, 0, -t, 0, 0, t, a, angle};
Cylinder(13) = {rb, 0, -t, 0, 0, t, hole};
BooleanDifference(14) = { Volume{11}; Delete; }{ Volume{12, 13}; Delete; };
Disk(1001) = {rb, 0, -t, head};
lower() = BooleanFragments{ Volume{14}; Delete; }{ Surface{1001}; Delete; };

Cylinder(21) = {rb, 0, -t, 0, 0, 2*t, shank, Pi};
Cylinder(22) = {rb, 0, t, 0, 0, high, head, Pi};
Cylinder(23) = {rb, 0, -t - high, 0, 0, high, head, Pi};
BooleanUnion(24) = { Volume{21}; Delete; }{ Volume{22, 23}; Delete; };
// what the discs leave outside of the flanges
Recursive Delete { Surface{:}; }


// names; the lower flange is meshed coarser than the upper one
parts() = {upper(0), lower(0)};
For k In {0 : 1}
  sign = 1 - 2*k;
  plane0() = {}; plane30() = {}; joint() = {}; seat() = {}; face() = {}; bore() = {}; rim() = {}; bolthole() = {};
  faces() = Boundary{ Volume{parts(k)}; };
  For j In {0 : #faces()-1}
    f = Abs(faces(j));
    box() = BoundingBox Surface{f};
    If (box(5) - box(2) < 0.1)
      If (Fabs(box(2)) < 0.1)
        joint() += {f};
      ElseIf (box(3) - box(0) < 2*head + 0.1)
        seat() += {f};
      Else
        face() += {f};
      EndIf
    ElseIf (box(4) < 0.1)
      plane0() += {f};
    ElseIf (box(3) < a + 0.1)
      bore() += {f};
    ElseIf (box(0) > b*Cos(angle) - 0.1)
      rim() += {f};
    ElseIf (box(1) > a*Sin(angle) - 0.1)
      plane30() += {f};
    Else
      bolthole() += {f};
    EndIf
  EndFor
  coarse = 7 + k; fine = 2.6 + 0.5*k;
  MeshSize{ PointsOf{ Volume{parts(k)}; } } = coarse;
  MeshSize{ PointsOf{ Surface{seat(), bolthole()}; } } = fine;
  If (k == 0)
    Physical Volume("upper") = {parts(k)};
  Else
    Physical Volume("lower") = {parts(k)};
  EndIf
  planes0() += plane0(); planes30() += plane30(); joints() += joint(); seats() += seat(); outsides() += face(); bores() += bore();
EndFor
Physical Surface("plane0") = {planes0()};
Physical Surface("plane30") = {planes30()};
Physical Surface("joint") = {joints()};
Physical Surface("seat") = {seats()};
Physical Surface("outside") = {outsides()};
Physical Surface("bore") = {bores()};

faces() = Boundary{ Volume{24}; };
For j In {0 : #faces()-1}
  f = Abs(faces(j));
  box() = BoundingBox Surface{f};
  If (box(4) < 0.1)
    middle() += {f};
  ElseIf (box(5) - box(2) < 0.1 && Fabs(box(2) - t) < 0.1)
    under_head() += {f};
  ElseIf (box(5) - box(2) < 0.1 && Fabs(box(2) + t) < 0.1)
    under_nut() += {f};
  EndIf
EndFor
MeshSize{ PointsOf{ Volume{24}; } } = 4;
MeshSize{ PointsOf{ Surface{under_head(), under_nut()}; } } = 2.8;
Physical Volume("bolt") = {24};
Physical Surface("middle") = {middle()};
Physical Surface("under_head") = {under_head()};
Physical Surface("under_nut") = {under_nut()};
