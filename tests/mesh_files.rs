//! Mesh files.
use hydroelastic::io::*;
#[test]
fn quick() {
    for f in ["bracket.msh","bracket_binary.msh","bracket.vtk","bracket_binary.vtk","bracket_extents.vtk","bracket_extents_binary.vtk","bracket_extents.vtu","bracket_extents_binary.vtu","bracket_extents_zlib.vtu"] {
        let p = format!("tests/data/meshes_from_mesher/{f}");
        match read_mesh(&p) { Ok(m)=> println!("{f} {} {} {} {:?}", m.mesh.vertex_count(), m.mesh.tet_count(), m.mesh.volume(), m.point_data.keys()), Err(e)=>println!("{f}: {e} {e:?}") }
    }
}
