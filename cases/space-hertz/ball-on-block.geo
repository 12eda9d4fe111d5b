// A quarter of the lower half of a ball of radius 10 mm on a quarter of a block, fine where they touch: the radius of the contact
// is 0.402 mm. Each is meshed for itself; nodes do not match.
// gmsh ball-on-block.geo -3 -o ball-on-block.msh
SetFactory("OpenCASCADE");
R = 10; L = 20;
Box(1) = {0, 0, -L, L, L, L};
Sphere(2) = {0, 0, R, R};
Box(3) = {0, 0, 0, R, R, R};
BooleanIntersection(4) = { Volume{2}; Delete; }{ Volume{3}; Delete; };
e = 1e-3;
Physical Volume("block") = {1};
Physical Volume("ball") = {4};
Physical Surface("block_left") = Surface In BoundingBox {-e, -e, -L - e, e, L + e, e};
Physical Surface("block_front") = Surface In BoundingBox {-e, -e, -L - e, L + e, e, e};
Physical Surface("block_bottom") = Surface In BoundingBox {-e, -e, -L - e, L + e, L + e, -L + e};
top() = Surface In BoundingBox {-e, -e, -e, L + e, L + e, e};
Physical Surface("block_top") = top();
Physical Surface("ball_left") = Surface In BoundingBox {-e, -e, -e, e, R + e, R + e};
Physical Surface("ball_front") = Surface In BoundingBox {-e, -e, -e, R + e, e, R + e};
Physical Surface("ball_equator") = Surface In BoundingBox {-e, -e, R - e, R + e, R + e, R + e};
all() = Abs(Boundary{ Volume{4}; });
flat() = Surface In BoundingBox {-e, -e, -e, e, R + e, R + e};
flat() += Surface In BoundingBox {-e, -e, -e, R + e, e, R + e};
flat() += Surface In BoundingBox {-e, -e, R - e, R + e, R + e, R + e};
all() -= flat();
Physical Surface("ball_sphere") = all();
Field[1] = MathEval;
Field[1].F = "0.042 + 0.35*Max(0, sqrt(x*x + y*y + z*z) - 0.5)";
Background Field = 1;
Mesh.MeshSizeExtendFromBoundary = 0;
Mesh.MeshSizeFromPoints = 0;
Mesh.MeshSizeFromCurvature = 0;
Mesh.ElementOrder = 2;
Mesh.HighOrderOptimize = 2;
Mesh.Optimize = 1;
Mesh.OptimizeNetgen = 1;
Mesh.MshFileVersion = 4.1;
Mesh.Binary = 1;
