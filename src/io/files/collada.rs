//! Reader of COLLADA files: the triangles and polygons of the scene, with the transforms of its nodes. Materials, animations and the
//! deformation by skins are ignored.

use super::FileError;
use super::polygons::add_polygon;
use super::scene::{MAX_DEPTH, Scene, fan, strip};
use super::text_lines::{excerpt, xml_words};
use crate::mesh::TriangleSoup;
use nalgebra::{
    Isometry3, Matrix3, Matrix4, Point3, Rotation3, Translation3, Unit, Vector3, Vector4,
};
use roxmltree::{Document, Node, NodeId};
use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::ops::Range;
use std::path::Path;

type Cause = Box<dyn std::error::Error + Send + Sync>;

/// Rotation of the x axis onto z.
const X_UP: Matrix3<f64> = Matrix3::new(0.0, -1.0, 0.0, 0.0, 0.0, -1.0, 1.0, 0.0, 0.0);
/// Rotation of the y axis onto z.
pub(super) const Y_UP: Matrix3<f64> = Matrix3::new(1.0, 0.0, 0.0, 0.0, 0.0, -1.0, 0.0, 1.0, 0.0);

/// Reads the triangles (m) of a file in its own axes, and the rotation of its up axis onto z.
pub(super) fn read(path: &Path, bytes: &[u8]) -> Result<(TriangleSoup, Matrix3<f64>), FileError> {
    parse(bytes).map_err(|source| FileError::syntax(path, "COLLADA", source))
}

fn parse(bytes: &[u8]) -> Result<(TriangleSoup, Matrix3<f64>), Cause> {
    let text = std::str::from_utf8(bytes)?;
    let document = Document::parse(text)?;
    let root = document.root_element();
    if root.tag_name().name() != "COLLADA" {
        return Err("the root element is not <COLLADA>".into());
    }
    let asset = child(root, "asset");
    let unit = asset.and_then(|asset| child(asset, "unit")?.attribute("meter"));
    let unit = unit.map_or(Ok(1.0), str::parse::<f64>)?;
    let up = asset.and_then(|asset| child(asset, "up_axis")?.text());
    let rotation = match up.map(str::trim) {
        Some("X_UP") => X_UP,
        Some("Z_UP") => Matrix3::identity(),
        _ => Y_UP,
    };
    let elements = document.descendants().filter(Node::is_element);
    let reader = Reader {
        by_id: elements
            .filter_map(|node| Some((node.attribute("id")?, node)))
            .collect(),
        parts: HashMap::new(),
        scene: Scene::of_file(bytes.len()),
    };
    Ok((reader.soup(root, Matrix4::new_scaling(unit))?, rotation))
}

struct Reader<'a> {
    by_id: HashMap<&'a str, Node<'a, 'a>>,
    /// Triangles of the geometries that were read.
    parts: HashMap<&'a str, TriangleSoup>,
    scene: Scene,
}

impl<'a> Reader<'a> {
    fn soup(mut self, root: Node<'a, 'a>, unit: Matrix4<f64>) -> Result<TriangleSoup, Cause> {
        let scene = child(root, "scene").and_then(|scene| child(scene, "instance_visual_scene"));
        if let Some(scene) = scene {
            let scene = self.target(scene, "url")?;
            let nodes = children(scene, "node").map(|node| (node, 0, unit));
            self.add_nodes(nodes.collect())?;
        } else {
            // A file without a scene is a library of geometries.
            let geometries = root.descendants().filter(|node| has_tag(node, "geometry"));
            for geometry in geometries.collect::<Vec<_>>() {
                self.add(geometry, &unit)?;
            }
        }
        Ok(self.scene.soup)
    }

    fn add_nodes(
        &mut self,
        mut stack: Vec<(Node<'a, 'a>, usize, Matrix4<f64>)>,
    ) -> Result<(), Cause> {
        while let Some((node, depth, parent)) = stack.pop() {
            if depth > MAX_DEPTH {
                return Err("the tree of nodes is too deep, or contains itself".into());
            }
            let transform = parent * transform(node)?;
            // Each visit of a node counts towards the limit of the scene, even if the node has no triangles.
            self.scene.add(&TriangleSoup::default(), &transform)?;
            for element in node.children().filter(Node::is_element) {
                match element.tag_name().name() {
                    "node" => stack.push((element, depth + 1, transform)),
                    "instance_node" => {
                        let node = self.target(element, "url")?;
                        stack.push((node, depth + 1, transform));
                    }
                    "instance_geometry" => {
                        let geometry = self.target(element, "url")?;
                        self.add(geometry, &transform)?;
                    }
                    "instance_controller" => {
                        let controller = self.target(element, "url")?;
                        if let Some(skin) = child(controller, "skin") {
                            let geometry = self.target(skin, "source")?;
                            let bind_shape = child(skin, "bind_shape_matrix").map(matrix);
                            let bind_shape = bind_shape.unwrap_or(Ok(Matrix4::identity()))?;
                            self.add(geometry, &(transform * bind_shape))?;
                        }
                    }
                    _ => {}
                }
            }
        }
        Ok(())
    }

    /// Adds the triangles of a `<geometry>` with a `<mesh>`.
    fn add(&mut self, geometry: Node<'a, 'a>, transform: &Matrix4<f64>) -> Result<(), Cause> {
        let id = geometry.attribute("id").unwrap_or_default();
        if id.is_empty() || !self.parts.contains_key(id) {
            let mut part = TriangleSoup::default();
            let mut sources = HashMap::new();
            for list in child(geometry, "mesh").iter().flat_map(Node::children) {
                let kind = list.tag_name().name();
                if ["triangles", "polylist", "polygons", "tristrips", "trifans"].contains(&kind) {
                    self.read_list(list, &mut part, &mut sources)?;
                }
            }
            self.parts.insert(id, part);
        }
        Ok(self
            .parts
            .get(id)
            .map_or(Ok(()), |part| self.scene.add(part, transform))?)
    }

    /// Adds the triangles or polygons of a list. `sources` has the vertices of the `<vertices>` that were read before.
    fn read_list(
        &mut self,
        list: Node<'a, 'a>,
        part: &mut TriangleSoup,
        sources: &mut HashMap<NodeId, Range<usize>>,
    ) -> Result<(), Cause> {
        let inputs: Vec<Node<'a, 'a>> = children(list, "input").collect();
        let offset =
            |input: &Node<'a, 'a>| input.attribute("offset").map_or(Ok(0), str::parse::<usize>);
        let offsets = inputs
            .iter()
            .map(offset)
            .collect::<Result<Vec<usize>, _>>()?;
        let stride = offsets
            .iter()
            .max()
            .map_or(1, |offset| offset.saturating_add(1));
        let vertex = inputs
            .iter()
            .position(|input| input.attribute("semantic") == Some("VERTEX"));
        let Some(vertex) = vertex else {
            return Ok(());
        };
        let vertices = self.target(inputs[vertex], "source")?;
        if let Entry::Vacant(entry) = sources.entry(vertices.id()) {
            let start = part.vertices.len();
            part.vertices.extend(self.positions(vertices)?);
            self.scene.charge(part.vertices.len() - start)?;
            entry.insert(start..part.vertices.len());
        }
        let Range { start, end } = sources.get(&vertices.id()).cloned().unwrap_or_default();
        let count = end - start;
        let paths = list.descendants().filter(|node| has_tag(node, "p"));
        for path in paths {
            let indices: Vec<usize> = numbers(path)?;
            let corners = indices
                .chunks_exact(stride)
                .map(|corner| corner[offsets[vertex]]);
            let corners: Vec<usize> = corners.collect();
            if let Some(corner) = corners.iter().find(|&&corner| corner >= count) {
                return Err(format!(
                    "a face refers to vertex {corner}, but there are {count} vertices"
                )
                .into());
            }
            let corners: Vec<usize> = corners.iter().map(|corner| start + corner).collect();
            match list.tag_name().name() {
                "triangles" => part.triangles.extend(corners.as_chunks::<3>().0),
                "tristrips" => part.triangles.extend(strip(&corners)),
                "trifans" => part.triangles.extend(fan(&corners)),
                "polygons" => add_polygon(part, &corners)?,
                _ => add_polygons(part, &corners, child(list, "vcount"))?,
            }
        }
        Ok(())
    }

    /// Positions of an element `<vertices>`.
    fn positions(&self, vertices: Node<'a, 'a>) -> Result<Vec<Vector3<f64>>, Cause> {
        let position = children(vertices, "input")
            .find(|input| input.attribute("semantic") == Some("POSITION"));
        let source = self.target(position.ok_or("vertices have no positions")?, "source")?;
        let numbers: Vec<f64> = child(source, "float_array").map_or(Ok(Vec::new()), numbers)?;
        let accessor = source.descendants().find(|node| has_tag(node, "accessor"));
        let attribute = |name: &str, default: usize| {
            let text = accessor.and_then(|accessor| accessor.attribute(name));
            text.map_or(Ok(default), str::parse::<usize>)
        };
        let (stride, offset) = (attribute("stride", 3)?, attribute("offset", 0)?);
        if stride < 3 {
            return Err("positions must have three coordinates".into());
        }
        let points = numbers.get(offset..).unwrap_or_default().chunks(stride);
        Ok(points
            .filter(|point| point.len() >= 3)
            .map(|point| Vector3::new(point[0], point[1], point[2]))
            .collect())
    }

    /// Element that an attribute refers to by "#id".
    fn target(&self, node: Node<'a, 'a>, attribute: &str) -> Result<Node<'a, 'a>, Cause> {
        let address = node.attribute(attribute).unwrap_or_default();
        let target = address.strip_prefix('#').and_then(|id| self.by_id.get(id));
        target.copied().ok_or_else(|| {
            let tag = node.tag_name().name();
            format!("<{tag}> refers to {address:?}, but the file has no such element").into()
        })
    }
}

/// Adds the polygons of a `<polylist>`.
fn add_polygons(
    part: &mut TriangleSoup,
    corners: &[usize],
    counts: Option<Node>,
) -> Result<(), Cause> {
    let counts: Vec<usize> = counts.map_or(Ok(Vec::new()), numbers)?;
    let mut rest = corners;
    for count in counts {
        let (polygon, after) = rest
            .split_at_checked(count)
            .ok_or("the list of polygons is truncated")?;
        add_polygon(part, polygon)?;
        rest = after;
    }
    Ok(())
}

/// Matrix of an element with 16 numbers.
fn matrix(element: Node) -> Result<Matrix4<f64>, Cause> {
    let values: Vec<f64> = numbers(element)?;
    if values.len() == 16 {
        return Ok(Matrix4::from_row_slice(&values));
    }
    let tag = element.tag_name().name();
    Err(format!("<{tag}> has {} numbers", values.len()).into())
}

/// Transform of a node into its parent: the product of its transform elements.
fn transform(node: Node) -> Result<Matrix4<f64>, Cause> {
    let mut product = Matrix4::identity();
    for element in node.children().filter(Node::is_element) {
        let tag = element.tag_name().name();
        if tag == "skew" {
            return Err("a node has the transform <skew>: replace it by a <matrix>".into());
        }
        if !["matrix", "translate", "rotate", "scale", "lookat"].contains(&tag) {
            continue;
        }
        let values: Vec<f64> = numbers(element)?;
        product *= match (tag, &values[..]) {
            ("matrix", _) => matrix(element)?,
            ("lookat", values) if values.len() == 9 => {
                let [eye, target] = [0, 3].map(|k| Point3::from_slice(&values[k..k + 3]));
                let up = Vector3::from_column_slice(&values[6..]);
                let view = Isometry3::look_at_rh(&eye, &target, &up);
                view.inverse().to_homogeneous()
            }
            ("translate", &[x, y, z]) => Translation3::new(x, y, z).to_homogeneous(),
            ("scale", &[x, y, z]) => Matrix4::from_diagonal(&Vector4::new(x, y, z, 1.0)),
            ("rotate", &[x, y, z, degrees]) => {
                let axis = Unit::new_normalize(Vector3::new(x, y, z));
                Rotation3::from_axis_angle(&axis, degrees.to_radians()).to_homogeneous()
            }
            _ => return Err(format!("<{tag}> has {} numbers", values.len()).into()),
        };
    }
    Ok(product)
}

/// Whitespace-separated numbers of an element.
fn numbers<T: std::str::FromStr>(element: Node) -> Result<Vec<T>, Cause> {
    let tag = element.tag_name().name();
    let number = |word: &str| {
        word.parse().map_err(|_| {
            let start = excerpt(word.as_bytes());
            format!("<{tag}> has {start:?} instead of a number").into()
        })
    };
    xml_words(element).map(number).collect()
}

fn children<'a>(node: Node<'a, 'a>, tag: &str) -> impl Iterator<Item = Node<'a, 'a>> {
    node.children().filter(move |child| has_tag(child, tag))
}

fn child<'a>(node: Node<'a, 'a>, tag: &str) -> Option<Node<'a, 'a>> {
    children(node, tag).next()
}

/// Returns true for an element with this name in any namespace.
fn has_tag(node: &Node, tag: &str) -> bool {
    node.is_element() && node.tag_name().name() == tag
}
