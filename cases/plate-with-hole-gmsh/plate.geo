// Quarter of a plate with a round hole: radius 10, half length 120, half width 50.
// gmsh plate.geo -2 -format msh41 -o plate.msh
a = 10;
at_hole = a*Pi/2/24;
far = 12;
Point(1) = {0, 0, 0};
Point(2) = {a, 0, 0, at_hole};
Point(3) = {120, 0, 0, far};
Point(4) = {120, 50, 0, far};
Point(5) = {0, 50, 0, far};
Point(6) = {0, a, 0, at_hole};
Line(1) = {2, 3};
Line(2) = {3, 4};
Line(3) = {4, 5};
Line(4) = {5, 6};
Circle(5) = {6, 1, 2};
Curve Loop(1) = {1, 2, 3, 4, 5};
Plane Surface(1) = {1};
Physical Surface("plate") = {1};
Physical Curve("y-symmetry") = {1};
Physical Curve("end") = {2};
Physical Curve("edge") = {3};
Physical Curve("x-symmetry") = {4};
Physical Curve("hole") = {5};
Mesh.ElementOrder = 2;
