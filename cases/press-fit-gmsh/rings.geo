// Quarters of two rings, radii 20, 40 and 80. The surfaces share the circle between them, so their nodes there coincide.
// gmsh rings.geo -2 -format msh41 -o rings.msh
around = 12;
Point(1) = {0, 0, 0};
Point(2) = {20, 0, 0};
Point(3) = {40, 0, 0};
Point(4) = {80, 0, 0};
Point(5) = {0, 20, 0};
Point(6) = {0, 40, 0};
Point(7) = {0, 80, 0};
Circle(1) = {2, 1, 5};
Circle(2) = {3, 1, 6};
Circle(3) = {4, 1, 7};
Line(4) = {2, 3};
Line(5) = {5, 6};
Line(6) = {3, 4};
Line(7) = {6, 7};
Transfinite Curve {1, 2, 3} = around + 1;
Transfinite Curve {4, 5} = 5;
Transfinite Curve {6, 7} = 7;
Curve Loop(1) = {4, 2, -5, -1};
Plane Surface(1) = {1};
Curve Loop(2) = {6, 3, -7, -2};
Plane Surface(2) = {2};
// quadrilaterals inside, triangles outside
Transfinite Surface {1};
Recombine Surface {1};
Physical Surface("inner") = {1};
Physical Surface("outer") = {2};
Physical Curve("bore") = {1};
Physical Curve("fit") = {2};
Physical Curve("rim") = {3};
Physical Curve("on-x") = {4, 6};
Physical Curve("on-y") = {5, 7};
Mesh.ElementOrder = 2;
