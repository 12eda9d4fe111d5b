// Half (y >= 0) of the lower half of a ball of radius 10 on half of a block, fine where they touch: the radius of the contact is
// 0.402, edges 0.05. Each is meshed for itself; nodes do not match.
// gmsh ball-on-block.geo -3 -o ball-on-block.msh
SetFactory("OpenCASCADE");
R = 10; L = 20;
Box(1) = {-L, 0, -L, 2*L, L, L};
Sphere(2) = {0, 0, R, R};
Box(3) = {-R, 0, 0, 2*R, R, R};
BooleanIntersection(4) = { Volume{2}; Delete; }{ Volume{3}; Delete; };
e = 1e-3;
Physical Volume("block") = {1};
Physical Volume("ball") = {4};
Physical Surface("block_front") = Surface In BoundingBox {-L - e, -e, -L - e, L + e, e, e};
Physical Surface("block_bottom") = Surface In BoundingBox {-L - e, -e, -L - e, L + e, L + e, -L + e};
Physical Surface("block_top") = Surface In BoundingBox {-L - e, -e, -e, L + e, L + e, e};
front() = Surface In BoundingBox {-R - e, -e, -e, R + e, e, R + e};
equator() = Surface In BoundingBox {-R - e, -e, R - e, R + e, R + e, R + e};
Physical Surface("ball_front") = front();
Physical Surface("ball_equator") = equator();
all() = Abs(Boundary{ Volume{4}; });
all() -= front();
all() -= equator();
Physical Surface("ball_sphere") = all();
Field[1] = MathEval;
Field[1].F = "0.05 + 0.45*Max(0, sqrt(x*x + y*y + z*z) - 0.45)";
Background Field = 1;
Mesh.MeshSizeExtendFromBoundary = 0;
Mesh.MeshSizeFromPoints = 0;
Mesh.MeshSizeFromCurvature = 0;
Mesh.ElementOrder = 2;
Mesh.HighOrderOptimize = 2;
Mesh.Optimize = 1;
Mesh.OptimizeNetgen = 1;
Mesh.MshFileVersion = 2.2;
Mesh.Binary = 1;
