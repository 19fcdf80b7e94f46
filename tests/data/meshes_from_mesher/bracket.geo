// An angle bracket, 0.2 m x 0.1 m x 0.2 m, with a hole through its foot.
SetFactory("OpenCASCADE");
Box(1) = {0, 0, 0, 0.2, 0.1, 0.07};
Box(2) = {0, 0, 0.07, 0.07, 0.1, 0.13};
Cylinder(3) = {0.14, 0.05, -0.01, 0, 0, 0.09, 0.02};
BooleanUnion(4) = { Volume{1}; Delete; }{ Volume{2}; Delete; };
BooleanDifference(5) = { Volume{4}; Delete; }{ Volume{3}; Delete; };
Mesh.MeshSizeMin = 0.033;
Mesh.MeshSizeMax = 0.033;
