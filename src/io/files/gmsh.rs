use super::syntax_error::syntax_error_at;
use super::{FileError, file_contents::FileContents, gmsh_headers};
use mshio::mshfile::{ElementType, MshFile, NodeBlock};
use nalgebra::Vector3;
use std::collections::HashMap;
use std::path::Path;

const FORMAT: &str = "Gmsh 4.1";

/// Reads a Gmsh 4.1 file.
pub(super) fn read(path: &Path, mut bytes: Vec<u8>) -> Result<FileContents, FileError> {
    gmsh_headers::prepare(path, &mut bytes)?;
    let file = mshio::parse_msh_bytes(&bytes).map_err(|error| {
        // Uses only the first cause, because the message of the whole error contains the rest of the file.
        let (rest, cause) = match error.begin_msh_errors().next() {
            Some((rest, kind)) => (*rest, kind.to_string()),
            None => (&bytes[bytes.len()..], "unexpected text".into()),
        };
        syntax_error_at(rest, cause, (path, FORMAT, &bytes))
    })?;
    contents(path, &file)
}

fn contents(path: &Path, file: &MshFile<u64, i32, f64>) -> Result<FileContents, FileError> {
    let mut contents = FileContents::default();
    let mut indices = HashMap::new();
    for block in file.data.nodes.iter().flat_map(|n| &n.node_blocks) {
        add_vertices(path, block, &mut contents.vertices, &mut indices)?;
    }
    for block in file.data.elements.iter().flat_map(|e| &e.element_blocks) {
        if !is_tets(path, block.entity_dim, block.element_type)? {
            continue;
        }
        for element in &block.elements {
            let tet = contents.tets.len();
            contents
                .tets
                .push(corners(path, tet, &element.nodes, &indices)?);
        }
    }
    Ok(contents)
}

/// Appends the vertices of a block, and maps their tags to their indices.
fn add_vertices(
    path: &Path,
    block: &NodeBlock<u64, i32, f64>,
    vertices: &mut Vec<Vector3<f64>>,
    indices: &mut HashMap<u64, u64>,
) -> Result<(), FileError> {
    let tags = block.node_tags.iter().flatten();
    let (first, mut tag_count) = (vertices.len(), 0);
    for (&tag, &index) in tags {
        tag_count += 1;
        if indices.insert(tag, (first + index) as u64).is_some() {
            let path = path.into();
            return Err(FileError::RepeatedTag { path, tag });
        }
    }
    // mshio has merged repeated tags of the block.
    if tag_count != block.nodes.len() {
        return Err(FileError::TooShort {
            path: path.into(),
            part: "list of different node tags".into(),
            found: tag_count,
            expected: block.nodes.len(),
        });
    }
    vertices.extend(block.nodes.iter().map(|n| Vector3::new(n.x, n.y, n.z)));
    Ok(())
}

/// Whether the elements of a block are linear tetrahedra.
///
/// # Errors
/// If the elements are other solids.
fn is_tets(path: &Path, dimension: i32, element: ElementType) -> Result<bool, FileError> {
    use ElementType as E;
    let (path, found) = (path.into(), format!("{element:?}"));
    match element {
        E::Tet4 => Ok(true),
        E::Tet10 | E::Tet20 | E::Tet35 | E::Tet56 | E::Tet84 | E::Tet22 | E::Tet28 => {
            Err(FileError::HigherOrder { path, found })
        }
        _ if dimension == 3 => Err(FileError::OtherSolid { path, found }),
        _ => Ok(false),
    }
}

fn corners(
    path: &Path,
    tet: usize,
    tags: &[u64],
    indices: &HashMap<u64, u64>,
) -> Result<[u64; 4], FileError> {
    let mut corners = [0; 4];
    for (corner, tag) in corners.iter_mut().zip(tags) {
        *corner = *indices.get(tag).ok_or_else(|| FileError::UnknownVertex {
            path: path.into(),
            tet,
            vertex: *tag,
        })?;
    }
    Ok(corners)
}
