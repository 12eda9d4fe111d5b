// A quarter of a block, 12 a in every direction, with a quarter of the disc that a punch of radius a = 1 covers: cells of a/20 at
// the edge of the disc, a/8 in its middle.
// gmsh block.geo -3 -o block.msh
SetFactory("OpenCASCADE");
L = 12;
Box(1) = {0, 0, -L, L, L, L};
Disk(100) = {0, 0, 0, 1};
Rectangle(101) = {0, 0, 0, 2, 2};
BooleanIntersection(102) = { Surface{100}; Delete; }{ Surface{101}; Delete; };
BooleanFragments{ Volume{1}; Delete; }{ Surface{102}; Delete; }
e = 1e-3;
Physical Volume("block") = {1};
left() = Surface In BoundingBox {-e, -e, -L - e, e, L + e, e};
front() = Surface In BoundingBox {-e, -e, -L - e, L + e, e, e};
right() = Surface In BoundingBox {L - e, -e, -L - e, L + e, L + e, e};
back() = Surface In BoundingBox {-e, L - e, -L - e, L + e, L + e, e};
bottom() = Surface In BoundingBox {-e, -e, -L - e, L + e, L + e, -L + e};
sole() = Surface In BoundingBox {-e, -e, -e, 1 + e, 1 + e, e};
top() = Surface In BoundingBox {-e, -e, -e, L + e, L + e, e};
top() -= sole();
Physical Surface("left") = left();
Physical Surface("front") = front();
Physical Surface("right") = right();
Physical Surface("back") = back();
Physical Surface("bottom") = bottom();
Physical Surface("sole") = sole();
Physical Surface("top") = top();
Field[1] = MathEval;
Field[1].F = "0.05 + 0.35*Max(0, sqrt((sqrt(x*x + y*y) - 1)^2 + z*z) - 0.1)";
Field[2] = MathEval;
Field[2].F = "0.125 + 0.4*Max(0, sqrt(x*x + y*y + z*z) - 1)";
Field[3] = Min; Field[3].FieldsList = {1, 2};
Background Field = 3;
Mesh.MeshSizeExtendFromBoundary = 0;
Mesh.MeshSizeFromPoints = 0;
Mesh.MeshSizeFromCurvature = 0;
Mesh.ElementOrder = 2;
Mesh.HighOrderOptimize = 2;
Mesh.Optimize = 1;
Mesh.OptimizeNetgen = 1;
Mesh.MshFileVersion = 4.1;
Mesh.Binary = 1;
