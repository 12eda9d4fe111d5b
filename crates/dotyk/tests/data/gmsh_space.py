import gmsh, sys
gmsh.initialize(); gmsh.option.setNumber("General.Terminal",0)
print(gmsh.__version__)
def out(name, variants):
    for v,b,suffix in variants:
        gmsh.option.setNumber("Mesh.MshFileVersion",v); gmsh.option.setNumber("Mesh.Binary",b)
        gmsh.write(f"{name}_{suffix}.msh")
ALL=[(2.2,0,"22"),(2.2,1,"22b"),(4.1,0,"41"),(4.1,1,"41b")]
# quarter of a pipe r 1..2, height 1.5, by extrusion
def pipe(kind, order, incomplete, variants, name):
    gmsh.clear(); gmsh.model.add("p"); g=gmsh.model.geo
    gmsh.option.setNumber("Mesh.ElementOrder",1); gmsh.option.setNumber("Mesh.SecondOrderIncomplete",0)
    c=g.addPoint(0,0,0); p=[g.addPoint(1,0,0),g.addPoint(2,0,0),g.addPoint(0,2,0),g.addPoint(0,1,0)]
    l=[g.addLine(p[0],p[1]),g.addCircleArc(p[1],c,p[2]),g.addLine(p[2],p[3]),g.addCircleArc(p[3],c,p[0])]
    s=g.addPlaneSurface([g.addCurveLoop(l)])
    if kind!='tet':
        g.mesh.setTransfiniteCurve(l[0],2); g.mesh.setTransfiniteCurve(l[2],2); g.mesh.setTransfiniteCurve(l[1],4); g.mesh.setTransfiniteCurve(l[3],4); g.mesh.setTransfiniteSurface(s)
    if kind=='hex': g.mesh.setRecombine(2,s)
    if kind=='tet': e=g.extrude([(2,s)],0,0,1.5)
    else: e=g.extrude([(2,s)],0,0,1.5,[2],recombine=True)
    g.synchronize()
    # e: top, volume, then lateral in order of l
    vol=[x for x in e if x[0]==3][0][1]; top=e[0][1]; lat=[x[1] for x in e if x[0]==2][1:]
    gmsh.model.addPhysicalGroup(3,[vol],name="pipe"); gmsh.model.addPhysicalGroup(2,[top],name="top"); gmsh.model.addPhysicalGroup(2,[s],name="bottom")
    for n,t in zip(["start","outer","end","inner"],lat): gmsh.model.addPhysicalGroup(2,[t],name=n)
    gmsh.model.addPhysicalGroup(0,[p[1]],name="corner")
    gmsh.option.setNumber("Mesh.MeshSizeMin",0.7); gmsh.option.setNumber("Mesh.MeshSizeMax",0.9)
    gmsh.model.mesh.generate(3)
    gmsh.option.setNumber("Mesh.SecondOrderIncomplete",incomplete)
    if order==2: gmsh.model.mesh.setOrder(2)
    t=gmsh.model.mesh.getElements(3)
    print(name, t[0], [len(x) for x in t[1]], 'nodes', len(gmsh.model.mesh.getNodes()[0]))
    out(name, variants)
pipe('tet',1,0,[(4.1,0,"41")],'pipe_tet4'); pipe('tet',2,0,ALL,'pipe_tet10')
pipe('hex',1,0,[(2.2,1,"22b")],'pipe_hex8'); pipe('hex',2,1,[(4.1,0,"41")],'pipe_hex20'); pipe('hex',2,0,ALL,'pipe_hex27')
pipe('prism',1,0,[(4.1,1,"41b")],'pipe_prism6'); pipe('prism',2,1,[(2.2,0,"22")],'pipe_prism15'); pipe('prism',2,0,ALL,'pipe_prism18')
# pyramids: a hex box beside tets
gmsh.clear(); gmsh.model.add("y"); gmsh.option.setNumber("Mesh.ElementOrder",1)
n=[(0,0,0),(1,0,0),(1,1,0),(0,1,0),(.5,.5,1)]
v=gmsh.model.addDiscreteEntity(3); gmsh.model.mesh.addNodes(3,v,list(range(1,6)),[c for p in n for c in p]); gmsh.model.mesh.addElementsByType(v,7,[1],[1,2,3,4,5]); gmsh.model.addPhysicalGroup(3,[v],name="tent"); out('pyramid',[(4.1,0,"41")])
# a shell: surface mesh of a box only
gmsh.clear(); gmsh.model.add("s"); gmsh.model.occ.addBox(0,0,0,1,1,1); gmsh.model.occ.synchronize(); gmsh.model.addPhysicalGroup(2,[1,2,3,4,5,6],name="skin"); gmsh.option.setNumber("Mesh.MeshSizeMin",1); gmsh.option.setNumber("Mesh.MeshSizeMax",1); gmsh.model.mesh.generate(2); out('shell',[(4.1,0,"41")])
