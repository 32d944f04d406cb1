//! Animations of glTF files (glTF 2.0, 3.11 and appendix C): the turn, place and size of nodes, and the weights of morph targets, at a time.

use crate::scene::files::gltf_accessor::{self, NUMBERS};
use crate::scene::files::gltf_document::GltfDocument;
use glam::{DMat4, DQuat, DVec3, DVec4};
use gltf::accessor::Dimensions;
use gltf::scene::Transform;
use serde_json::Value;

type Checked<T> = Result<T, String>;

/// An animation of a file, played in a loop.
#[derive(Debug, PartialEq)]
pub(in crate::scene) struct GltfAnimation {
    pub name: String,
    channels: Vec<Channel>,
    /// The time of its last key, in seconds.
    pub duration_s: f64,
    /// Channels that move something other than a node's transform or weights.
    pub others: usize,
    /// Channels that are damaged and left out, and what is wrong with the first.
    pub damaged: (usize, String),
}

/// What moves one property of a node.
#[derive(Debug, PartialEq)]
struct Channel {
    node: usize,
    property: Property,
    interpolation: Interpolation,
    times_s: Vec<f64>,
    /// The numbers of all keys; a cubic spline has three times as many: in-tangent, value and out-tangent of each.
    numbers: Vec<f64>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Property {
    Translation,
    Rotation,
    Scale,
    Weights,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Interpolation {
    Step,
    Linear,
    CubicSpline,
}

/// The state of a node; `None` where it is at rest.
#[derive(Clone, Default)]
pub(in crate::scene) struct NodePose {
    translation: Option<DVec3>,
    rotation: Option<DQuat>,
    scale: Option<DVec3>,
    pub weights: Option<Vec<f64>>,
}

impl NodePose {
    /// Returns the transform of a node: at rest it has this transform, or this place if that is known in f64.
    pub fn to_parent(&self, rest: &Transform, place: Option<DVec3>) -> DMat4 {
        let is_at_rest = self.translation.is_none() && self.rotation.is_none() && self.scale.is_none();
        let (translation, rotation, scale) = match *rest {
            // The node's own parts: a scale of 0, or a negative one, does not come back out of a matrix.
            Transform::Decomposed { translation, rotation, scale } if !is_at_rest => {
                let turn = DQuat::from_array(rotation.map(f64::from));
                (DVec3::from(translation.map(f64::from)), turn, DVec3::from(scale.map(f64::from)))
            }
            _ => {
                let columns = rest.clone().matrix().map(|column| column.map(f64::from));
                let mut matrix = DMat4::from_cols_array_2d(&columns);
                matrix.w_axis = place.map_or(matrix.w_axis, |place| place.extend(1.0));
                if is_at_rest {
                    return matrix;
                }
                let (scale, rotation, translation) = matrix.to_scale_rotation_translation();
                (translation, rotation, scale)
            }
        };
        let translation = self.translation.or(place).unwrap_or(translation);
        let (rotation, scale) = (self.rotation.unwrap_or(rotation), self.scale.unwrap_or(scale));
        DMat4::from_scale_rotation_translation(scale, rotation, translation)
    }
}

impl GltfAnimation {
    /// Reads the animation with the given name, or the first; `None` if the file has none.
    ///
    /// # Errors
    /// A message if there is no animation of that name.
    pub fn read(file: &GltfDocument, wanted: Option<&str>) -> Checked<Option<Self>> {
        let all = file.animations.as_array().map_or(&[][..], Vec::as_slice);
        let name = |index: usize| all[index]["name"].as_str().map_or_else(|| index.to_string(), str::to_owned);
        let index = match wanted {
            None if all.is_empty() => return Ok(None),
            None => 0,
            Some(wanted) => (0..all.len()).find(|index| name(*index) == wanted).ok_or_else(|| {
                let names = (0..all.len()).map(name).collect::<Vec<_>>().join(", ");
                format!("no animation {wanted}: it has {}", if names.is_empty() { "none" } else { &names })
            })?,
        };
        let mut animation =
            Self { name: name(index), channels: Vec::new(), duration_s: 0.0, others: 0, damaged: <_>::default() };
        let nodes = file.document.nodes().len();
        for channel in all[index]["channels"].as_array().into_iter().flatten() {
            let property = match channel["target"]["path"].as_str() {
                Some("translation") => Property::Translation,
                Some("rotation") => Property::Rotation,
                Some("scale") => Property::Scale,
                Some("weights") => Property::Weights,
                _ => {
                    animation.others += 1;
                    continue;
                }
            };
            // A channel without a node is of an extension.
            let Some(node) = number(&channel["target"]["node"]).filter(|node| *node < nodes) else {
                animation.others += 1;
                continue;
            };
            let sampler = number(&channel["sampler"]).map_or(&Value::Null, |i| &all[index]["samplers"][i]);
            let read = self::channel(file, node, property, sampler);
            match read {
                Ok(read) => {
                    animation.duration_s = animation.duration_s.max(read.times_s.last().copied().unwrap_or_default());
                    animation.channels.push(read);
                }
                Err(cause) => {
                    if animation.damaged.0 == 0 {
                        animation.damaged.1 = format!("node {node}: {cause}");
                    }
                    animation.damaged.0 += 1;
                }
            }
        }
        Ok(Some(animation))
    }

    /// Returns the state of every node at a time.
    pub fn poses(&self, nodes: usize, time_s: f64) -> Vec<NodePose> {
        let time_s = if self.duration_s > 0.0 { time_s.rem_euclid(self.duration_s) } else { 0.0 };
        let mut poses = vec![NodePose::default(); nodes];
        for channel in &self.channels {
            let Some(pose) = poses.get_mut(channel.node) else { continue };
            let found = channel.at(time_s);
            let three = || DVec3::from_slice(&found[..3]);
            match channel.property {
                Property::Translation => pose.translation = Some(three()),
                Property::Scale => pose.scale = Some(three()),
                Property::Rotation => pose.rotation = Some(DQuat::from_slice(&found[..4])),
                Property::Weights => pose.weights = Some(found),
            }
        }
        poses
    }
}

fn number(value: &Value) -> Option<usize> {
    value.as_u64().and_then(|value| usize::try_from(value).ok())
}

fn channel(file: &GltfDocument, node: usize, property: Property, sampler: &Value) -> Checked<Channel> {
    let interpolation = match sampler["interpolation"].as_str() {
        None | Some("LINEAR") => Interpolation::Linear,
        Some("STEP") => Interpolation::Step,
        Some("CUBICSPLINE") => Interpolation::CubicSpline,
        Some(other) => return Err(format!("interpolation {other} is not known")),
    };
    let times_s = numbers(file, &sampler["input"], Dimensions::Scalar).map_err(|cause| format!("input {cause}"))?;
    let dimensions = match property {
        Property::Translation | Property::Scale => Dimensions::Vec3,
        Property::Rotation => Dimensions::Vec4,
        Property::Weights => Dimensions::Scalar,
    };
    let numbers = numbers(file, &sampler["output"], dimensions).map_err(|cause| format!("output {cause}"))?;
    let per_key = if interpolation == Interpolation::CubicSpline { 3 } else { 1 };
    if !times_s.windows(2).all(|pair| pair[0] < pair[1]) || !times_s.iter().all(|time_s| time_s.is_finite()) {
        return Err("its times do not increase".into());
    }
    if times_s.is_empty() || numbers.is_empty() || numbers.len() % (times_s.len() * per_key) != 0 {
        return Err(format!("{} numbers for {} keys", numbers.len(), times_s.len()));
    }
    let width = numbers.len() / times_s.len() / per_key;
    if property != Property::Weights && width != dimensions.multiplicity() {
        return Err(format!("{width} numbers for each key"));
    }
    if !numbers.iter().all(|number| number.is_finite()) {
        return Err("a number is not finite".into());
    }
    Ok(Channel { node, property, interpolation, times_s, numbers })
}

/// Returns all numbers of the accessor with this index.
fn numbers(file: &GltfDocument, index: &Value, dimensions: Dimensions) -> Checked<Vec<f64>> {
    let accessor = number(index).and_then(|index| file.document.accessors().nth(index)).ok_or("has no accessor")?;
    let elements = gltf_accessor::elements(file, &accessor, dimensions, &NUMBERS)?;
    let all = elements.iter().flat_map(|element| {
        let four: [f64; 4] = gltf_accessor::numbers(&accessor, element);
        four.into_iter().take(dimensions.multiplicity())
    });
    Ok(all.collect())
}

impl Channel {
    /// Returns the property's numbers at a time; before the first key and after the last it keeps theirs.
    fn at(&self, time_s: f64) -> Vec<f64> {
        let per_key = if self.interpolation == Interpolation::CubicSpline { 3 } else { 1 };
        let width = self.numbers.len() / self.times_s.len() / per_key;
        let part = |key: usize, part: usize| &self.numbers[(key * per_key + part) * width..][..width];
        let value = |key: usize| part(key, per_key / 2);
        let next = self.times_s.partition_point(|key_s| *key_s <= time_s);
        let last = self.times_s.len() - 1;
        let found = if next == 0 || next > last || self.interpolation == Interpolation::Step {
            value(next.saturating_sub(1)).to_vec()
        } else {
            let (before, step_s) = (next - 1, self.times_s[next] - self.times_s[next - 1]);
            let t = (time_s - self.times_s[before]) / step_s;
            match (self.interpolation, self.property) {
                (Interpolation::CubicSpline, _) => {
                    let (t2, t3) = (t * t, t * t * t);
                    let hermite = |i: usize| {
                        let [a, b] = [value(before)[i], value(next)[i]];
                        let [out, into] = [step_s * part(before, 2)[i], step_s * part(next, 0)[i]];
                        (2.0 * t3 - 3.0 * t2 + 1.0) * a
                            + (t3 - 2.0 * t2 + t) * out
                            + (3.0 * t2 - 2.0 * t3) * b
                            + (t3 - t2) * into
                    };
                    (0..width).map(hermite).collect()
                }
                (_, Property::Rotation) => {
                    let [a, b] = [value(before), value(next)].map(|four| DQuat::from_vec4(unit(four)));
                    a.slerp(b, t).to_array().to_vec()
                }
                _ => value(before).iter().zip(value(next)).map(|(a, b)| a + (b - a) * t).collect(),
            }
        };
        match self.property {
            Property::Rotation => unit(&found).to_array().to_vec(),
            _ => found,
        }
    }
}

/// Returns a quaternion of length 1; one of length 0 turns nothing.
fn unit(four: &[f64]) -> DVec4 {
    DVec4::from_slice(four).try_normalize().unwrap_or(DVec4::W)
}
