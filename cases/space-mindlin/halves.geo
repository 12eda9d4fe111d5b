// Two halves (y >= 0) of half-balls of radius 8 about the middle of the contact, whose radius is 1: below and above the plane
// z = 0, each meshed for itself, so that nodes do not match. Edges of 1/13 and 1/10 where they touch, growing outwards.
// gmsh halves.geo -3 -o halves.msh
L = 8;
Macro Half                       // s: side of the plane, h: size of edges in the contact
  p = newp;
  Point(p) = {0, 0, 0};
  Point(p+1) = {L, 0, 0};
  Point(p+2) = {-L, 0, 0};
  Point(p+3) = {0, L, 0};
  Point(p+4) = {0, 0, s*L};
  l = newl;
  Line(l) = {p, p+1};
  Line(l+1) = {p, p+2};
  Circle(l+2) = {p+1, p, p+3};
  Circle(l+3) = {p+3, p, p+2};
  Circle(l+4) = {p+1, p, p+4};
  Circle(l+5) = {p+4, p, p+2};
  Circle(l+6) = {p+3, p, p+4};
  c = newll;
  Curve Loop(c) = {l, l+2, l+3, -(l+1)};
  Curve Loop(c+1) = {l, l+4, l+5, -(l+1)};
  Curve Loop(c+2) = {l+2, l+6, -(l+4)};
  Curve Loop(c+3) = {l+3, -(l+5), -(l+6)};
  f = news;
  Plane Surface(f) = {c};
  Plane Surface(f+1) = {c+1};
  Surface(f+2) = {c+2};
  Surface(f+3) = {c+3};
  k = newsl;
  Surface Loop(k) = {f, f+1, f+2, f+3};
  v = newv;
  Volume(v) = {k};
  m = newf;
  Field[m] = MathEval;
  Field[m].F = Sprintf("Min(1.6, %g + 0.4*Max(0, sqrt(x*x + y*y) - 1.1) + 0.4*abs(z))", h);
  Field[m+1] = Restrict;
  Field[m+1].InField = m;
  Field[m+1].VolumesList = {v};
  Field[m+1].IncludeBoundary = 1;
Return

s = -1; h = 1/13;
Call Half;
Physical Volume("lower") = {v};
Physical Surface("lower_top") = {f};
Physical Surface("lower_front") = {f+1};
Physical Surface("lower_cut") = {f+2, f+3};
first = m+1;
s = 1; h = 1/10;
Call Half;
Physical Volume("upper") = {v};
Physical Surface("upper_bottom") = {f};
Physical Surface("upper_front") = {f+1};
Physical Surface("upper_cut") = {f+2, f+3};
b = newf;
Field[b] = Min;
Field[b].FieldsList = {first, m+1};
Background Field = b;
Mesh.MeshSizeExtendFromBoundary = 0;
Mesh.MeshSizeFromPoints = 0;
Mesh.MeshSizeFromCurvature = 0;
Mesh.ElementOrder = 2;
Mesh.HighOrderOptimize = 2;
Mesh.Optimize = 1;
Mesh.OptimizeNetgen = 1;
Mesh.MshFileVersion = 2.2;
Mesh.Binary = 1;
