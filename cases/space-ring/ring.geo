// A ring of twelve tapered segments, a = 2.6, b = 3, z from -0.6 to 0.6. Joint i lies in the plane through the radius at
// 30 i degrees that leans by 0.15 to the axis, to and fro: seen from outside the segments are trapezoids.
// Each segment is meshed for itself; meshes of neighbours do not match.
// gmsh ring.geo -3 -o ring.msh
SetFactory("OpenCASCADE");
Mesh.ElementOrder = 2;
Mesh.SecondOrderIncomplete = 1;
Mesh.MshFileVersion = 4.1;
Mesh.SaveAll = 0;
Geometry.OCCBoundsUseStl = 0;

a = 2.6; b = 3; h = 0.6; lean = Atan(0.15); n = 12; step = 2*Pi/n;
outer() = {}; inner() = {}; bottom() = {}; top() = {}; right() = {}; left() = {};

For i In {0 : n-1}
  sign = (i % 2 == 0) ? 1 : -1;
  v = 1000 + 10*i;
  Cylinder(v) = {0, 0, -h, 0, 0, 2*h, b};
  Cylinder(v+1) = {0, 0, -h, 0, 0, 2*h, a};
  // the seams of the cylinders away from the segment
  Rotate { {0, 0, 1}, {0, 0, 0}, (i+0.5)*step + Pi } { Volume{v, v+1}; }
  BooleanDifference(v+2) = { Volume{v}; Delete; }{ Volume{v+1}; Delete; };
  // behind joint i
  Box(v+3) = {0, 0, -5, 5, 5, 10};
  Rotate { {1, 0, 0}, {0, 0, 0}, -sign*lean } { Volume{v+3}; }
  Rotate { {0, 0, 1}, {0, 0, 0}, i*step } { Volume{v+3}; }
  // before joint i+1
  Box(v+4) = {0, -5, -5, 5, 5, 10};
  Rotate { {1, 0, 0}, {0, 0, 0}, sign*lean } { Volume{v+4}; }
  Rotate { {0, 0, 1}, {0, 0, 0}, (i+1)*step } { Volume{v+4}; }
  BooleanIntersection(v+5) = { Volume{v+2}; Delete; }{ Volume{v+3}; Delete; };
  BooleanIntersection(v+6) = { Volume{v+5}; Delete; }{ Volume{v+4}; Delete; };

  // even segments are finer than odd ones
  around = (sign > 0) ? 5 : 4;
  through = (sign > 0) ? 3 : 2;
  along = (sign > 0) ? 4 : 3;
  faces() = Boundary{ Volume{v+6}; };
  For k In {0 : #faces()-1}
    f = faces(k);
    edges() = Boundary{ Surface{f}; };
    For j In {0 : #edges()-1}
      e = Abs(edges(j));
      box() = BoundingBox Curve{e};
      wide = Sqrt((box(3)-box(0))^2 + (box(4)-box(1))^2);
      If (box(5)-box(2) > 0.6)
        Transfinite Curve{e} = along + 1;
      ElseIf (wide < 0.7)
        Transfinite Curve{e} = through + 1;
      Else
        Transfinite Curve{e} = around + 1;
      EndIf
    EndFor
    box() = BoundingBox Surface{f};
    area = Mass Surface{f};
    c() = CenterOfMass Surface{f};
    If (box(5)-box(2) < 0.1)
      If (c(2) < 0)
        bottom() += {f};
      Else
        top() += {f};
      EndIf
    ElseIf (area > 1.75)
      outer() += {f};
    ElseIf (area > 1.2)
      inner() += {f};
    Else
      // angle from the middle of the segment
      phi = (i+0.5)*step;
      If (c(1)*Cos(phi) - c(0)*Sin(phi) < 0)
        right() += {f};
      Else
        left() += {f};
      EndIf
    EndIf
  EndFor
  Physical Volume(Sprintf("s%g", i)) = {v+6};
EndFor
Transfinite Surface{:};
Recombine Surface{:};
Transfinite Volume{:};
Physical Surface("outer") = {outer()};
Physical Surface("inner") = {inner()};
Physical Surface("bottom") = {bottom()};
Physical Surface("top") = {top()};
Physical Surface("right") = {right()};
Physical Surface("left") = {left()};
