//! What the maps of a source see.

use aam_scene::{Aabb, Camera, Light, LightKind, Projection, ShadowLayout, ShadowSource, Up, View};
use glam::{DMat4, DVec3, DVec4, Vec3};

/// Texels around each face of a cube that its neighbours see too, so that no kernel ends at an edge.
const fn guard(kernel: f64) -> f64 {
    kernel + 1.5
}

/// The widest view of a single map, in radians: beyond it texels get too unequal.
const WIDEST: f64 = 2.3;

/// The nearest that a fitted volume begins, as a share of where it ends.
const NEAREST: f64 = 1e-3;

/// A map, or a layer of one, and what it sees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct MapView {
    /// World to the source's axes: x right, y up, −z away from it.
    pub view: DMat4,
    /// To clip space, depth 0 near, 1 far.
    pub projection: DMat4,
    pub near: f64,
    pub far: f64,
    /// Width of a texel in metres; of a pyramid at depth 1.
    pub texel: f64,
    /// Radius of the kernel in texels.
    pub radius: f64,
}

/// Where a source stands, and what its maps see.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Placement {
    pub views: Vec<MapView>,
    /// Views are pyramids; else boxes.
    pub perspective: bool,
    /// World position of the source; of a box its unit direction towards it.
    pub origin: DVec3,
    /// Depth from the camera at which each cascade ends.
    pub ends: Vec<f64>,
}

/// What of the scene a source's volume depends on.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Surroundings<'a> {
    pub lights: &'a [Light],
    pub up: Up,
    pub view: &'a View,
    /// The box around each caster and receiver.
    pub boxes: &'a [Aabb],
}

/// Places a source.
///
/// # Errors
/// A sentence that says why there is no volume.
pub(crate) fn place(source: &ShadowSource, around: &Surroundings<'_>) -> Result<Placement, String> {
    let settings = &source.settings;
    let size = f64::from(settings.resolution);
    let light = match source.light {
        Some(index) => Some(
            around
                .lights
                .get(index)
                .ok_or_else(|| format!("it belongs to light {index}, and the scene has {}", around.lights.len()))?,
        ),
        None => None,
    };
    if let (aam_scene::ShadowFilter::Volume, None, Some(light)) = (settings.technique.filter, &source.volume, light) {
        return everywhere(light);
    }
    let mut placement = match (settings.technique.layout, &source.volume, light) {
        (ShadowLayout::One, Some(camera), _) => of_camera(camera, size)?,
        (ShadowLayout::One, None, Some(light)) => around_scene(light, around, size)?,
        (ShadowLayout::Cascades, _, Some(light)) => {
            let LightKind::Directional { direction } = light.kind else {
                return Err("cascades are for directional lights; use another layout".into());
            };
            cascades(direction, source, around)?
        }
        (ShadowLayout::Cube, _, Some(light)) => {
            let (LightKind::Point { position, .. } | LightKind::Spot { position, .. }) = light.kind else {
                return Err("a directional light has no position to put a cube around; use one map or cascades".into());
            };
            cube(position.as_dvec3(), source, around)?
        }
        (_, _, None) => return Err("it belongs to no light and has no volume: give it either".into()),
    };
    let first = placement.views.first().map_or(1.0, |view| view.texel);
    for view in &mut placement.views {
        // The same width in the world in all cascades.
        view.radius = f64::from(settings.radius) * (first / view.texel);
        if settings.technique.layout != ShadowLayout::Cascades {
            view.radius = f64::from(settings.radius);
        }
    }
    if placement.views.iter().any(|view| !view.is_sound()) {
        return Err("its volume has no extent or is not finite".into());
    }
    Ok(placement)
}

impl MapView {
    fn perspective(view: DMat4, angle: f64, near: f64, far: f64, size: f64) -> Self {
        let projection = glam::camera::rh::proj::directx::perspective(angle as f32, 1.0, near as f32, far as f32);
        let mut exact = projection.as_dmat4();
        let scale = 1.0 / (0.5 * angle).tan();
        exact.x_axis.x = scale;
        exact.y_axis.y = scale;
        exact.z_axis.z = far / (near - far);
        exact.w_axis.z = near * far / (near - far);
        Self { view, projection: exact, near, far, texel: 2.0 * (0.5 * angle).tan() / size, radius: 0.0 }
    }

    fn orthographic(view: DMat4, width: f64, near: f64, far: f64, size: f64) -> Self {
        let projection = DMat4::from_cols(
            DVec4::new(2.0 / width, 0.0, 0.0, 0.0),
            DVec4::new(0.0, 2.0 / width, 0.0, 0.0),
            DVec4::new(0.0, 0.0, 1.0 / (near - far), 0.0),
            DVec4::new(0.0, 0.0, near / (near - far), 1.0),
        );
        Self { view, projection, near, far, texel: width / size, radius: 0.0 }
    }

    fn is_sound(&self) -> bool {
        (self.projection * self.view).is_finite() && self.texel > 0.0 && self.near < self.far
    }
}

/// World to the axes of something that looks in a direction.
fn looking(position: DVec3, direction: DVec3, up: DVec3) -> DMat4 {
    let back = -direction.normalize_or(DVec3::NEG_Z);
    let right = if up.cross(back).length() > 1e-3 { up.cross(back).normalize() } else { back.any_orthonormal_vector() };
    let up = back.cross(right);
    let rotation = DMat4::from_cols(right.extend(0.0), up.extend(0.0), back.extend(0.0), DVec4::W).transpose();
    rotation * DMat4::from_translation(-position)
}

/// From where a light shines, without bounds.
fn everywhere(light: &Light) -> Result<Placement, String> {
    let (perspective, origin) = match light.kind {
        LightKind::Directional { direction } => {
            (false, -direction.as_dvec3().try_normalize().ok_or("its light has no direction")?)
        }
        LightKind::Point { position, .. } | LightKind::Spot { position, .. } => (true, position.as_dvec3()),
    };
    if !origin.is_finite() {
        return Err("its light has no finite position".into());
    }
    Ok(Placement { views: Vec::new(), perspective, origin, ends: Vec::new() })
}

fn of_camera(camera: &Camera, size: f64) -> Result<Placement, String> {
    let (position, target) = (camera.position.as_dvec3(), camera.target.as_dvec3());
    let direction =
        (target - position).try_normalize().ok_or("its volume looks nowhere: position and target are one")?;
    let (near, far) = (f64::from(camera.near), f64::from(camera.far));
    if !(near < far && far.is_finite()) {
        return Err(format!("its volume reaches from {near} to {far}: near must be less than far, and both finite"));
    }
    let view = looking(position, direction, camera.up.as_dvec3());
    Ok(match camera.projection {
        Projection::Perspective { fov_y } => {
            let angle = f64::from(fov_y);
            if !(near > 0.0 && angle > 0.0 && angle < std::f64::consts::PI) {
                return Err(format!(
                    "its volume begins at {near} with an angle of {:.1} degrees; near must be above 0, the angle between 0 and 180",
                    angle.to_degrees()
                ));
            }
            let view = MapView::perspective(view, angle, near, far, size);
            Placement { views: vec![view], perspective: true, origin: position, ends: Vec::new() }
        }
        Projection::Orthographic { height } => {
            let view = MapView::orthographic(view, f64::from(height), near, far, size);
            Placement { views: vec![view], perspective: false, origin: -direction, ends: Vec::new() }
        }
    })
}

fn corners(aabb: &Aabb) -> impl Iterator<Item = DVec3> + use<> {
    let (low, high) = (aabb.min.as_dvec3(), aabb.max.as_dvec3());
    (0..8).map(move |corner| {
        DVec3::new(
            if corner & 1 == 0 { low.x } else { high.x },
            if corner & 2 == 0 { low.y } else { high.y },
            if corner & 4 == 0 { low.z } else { high.z },
        )
    })
}

fn all_corners<'a>(around: &Surroundings<'a>) -> impl Iterator<Item = DVec3> + use<'a> {
    around.boxes.iter().filter(|aabb| !aabb.is_empty()).flat_map(corners)
}

/// Least and greatest of what is seen along the axes of a view.
fn extent(view: &DMat4, points: impl Iterator<Item = DVec3>) -> (DVec3, DVec3) {
    points
        .map(|point| view.transform_point3(point))
        .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), point| (low.min(point), high.max(point)))
}

fn around_scene(light: &Light, around: &Surroundings<'_>, size: f64) -> Result<Placement, String> {
    let up = around.up.axis().as_dvec3();
    if around.boxes.iter().all(Aabb::is_empty) {
        return Err("there is nothing that casts or receives".into());
    }
    match light.kind {
        LightKind::Directional { direction } => {
            let direction = direction.as_dvec3().try_normalize().ok_or("its light has no direction")?;
            let view = looking(DVec3::ZERO, direction, up);
            let (low, high) = extent(&view, all_corners(around));
            let (middle, half) = (0.5 * (low + high), 0.5 * (high - low));
            // A texel and a half of margin, so that no kernel starts at the map's edge.
            let width = (2.0 * half.x.max(half.y)).max(1e-6) * (1.0 + 3.0 / size);
            let slack = 1e-3 * (high.z - low.z).max(width * 1e-3);
            let view = DMat4::from_translation(DVec3::new(-middle.x, -middle.y, 0.0)) * view;
            let map = MapView::orthographic(view, width, -high.z - slack, -low.z + slack, size);
            Ok(Placement { views: vec![map], perspective: false, origin: -direction, ends: Vec::new() })
        }
        LightKind::Spot { position, direction, outer, .. } => {
            let direction = direction.as_dvec3().try_normalize().ok_or("its light has no direction")?;
            let angle = 2.0 * f64::from(outer) * (1.0 + 3.0 / size);
            if angle > WIDEST {
                return Err(format!(
                    "its cone of {:.0} degrees is too wide for one map; use a cube layout",
                    angle.to_degrees()
                ));
            }
            pyramid(position.as_dvec3(), direction, angle, around, size)
        }
        LightKind::Point { position, .. } => {
            let position = position.as_dvec3();
            let (low, high) = extent(&DMat4::IDENTITY, all_corners(around));
            let direction = (0.5 * (low + high) - position).normalize_or(DVec3::NEG_Z);
            let half = all_corners(around)
                .map(|corner| (corner - position).normalize_or(-direction).dot(direction).clamp(-1.0, 1.0).acos())
                .fold(0.0, f64::max);
            let angle = (2.0 * half).max(1e-3) * (1.0 + 3.0 / size);
            if angle > WIDEST {
                return Err("its light stands among what it lights, which one map cannot see; use a cube layout".into());
            }
            pyramid(position, direction, angle, around, size)
        }
    }
}

/// Near and far of what there is in front of a place.
fn depth_range(depths: impl Iterator<Item = (f64, f64)>) -> Result<(f64, f64), String> {
    let (near, far) =
        depths.fold((f64::INFINITY, 0.0), |(near, far): (f64, f64), (low, high)| (near.min(low), far.max(high)));
    if !(far > 0.0 && far.is_finite()) {
        return Err("nothing that casts or receives is in front of its light".into());
    }
    let far = far * (1.0 + 1e-3);
    Ok(((near * (1.0 - 1e-3)).max(NEAREST * far), far))
}

fn pyramid(
    position: DVec3,
    direction: DVec3,
    angle: f64,
    around: &Surroundings<'_>,
    size: f64,
) -> Result<Placement, String> {
    let view = looking(position, direction, around.up.axis().as_dvec3());
    // Distance bounds depth from above, so that what is measured as distance fits too.
    let boxes = around.boxes.iter().filter(|aabb| !aabb.is_empty()).filter_map(|aabb| {
        let (low, high) = extent(&view, corners(aabb));
        let farthest = corners(aabb).map(|corner| corner.distance(position)).fold(0.0, f64::max);
        (low.z < 0.0).then_some((-high.z, farthest))
    });
    let (near, far) = depth_range(boxes)?;
    let map = MapView::perspective(view, angle, near, far, size);
    Ok(Placement { views: vec![map], perspective: true, origin: position, ends: Vec::new() })
}

fn cube(position: DVec3, source: &ShadowSource, around: &Surroundings<'_>) -> Result<Placement, String> {
    let size = f64::from(source.settings.resolution);
    let margin = guard(f64::from(source.settings.radius));
    if 2.0 * margin >= 0.5 * size {
        return Err(format!("{size} texels are too few for faces whose kernels reach {margin} beyond their edges"));
    }
    let boxes = around.boxes.iter().filter(|aabb| !aabb.is_empty()).map(|aabb| {
        let nearest = position.clamp(aabb.min.as_dvec3(), aabb.max.as_dvec3()).distance(position);
        // Depth along the axis of a face is down to 1/√3 of distance.
        (nearest / 3.0_f64.sqrt(), corners(aabb).map(|corner| corner.distance(position)).fold(0.0, f64::max))
    });
    let (near, far) = depth_range(boxes)?;
    let angle = 2.0 * (size / (size - 2.0 * margin)).atan();
    let faces = [DVec3::X, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Y, DVec3::Z, DVec3::NEG_Z];
    let views = faces.map(|axis| {
        let up = if axis.y.abs() > 0.5 { DVec3::Z } else { DVec3::Y };
        MapView::perspective(looking(position, axis, up), angle, near, far, size)
    });
    Ok(Placement { views: views.to_vec(), perspective: true, origin: position, ends: Vec::new() })
}

/// One box for each range of depths from the camera, around the sphere that holds it, moved in steps of whole texels:
/// so neither turning nor moving the camera moves the edges of shadows (Valient 2007).
fn cascades(direction: Vec3, source: &ShadowSource, around: &Surroundings<'_>) -> Result<Placement, String> {
    let settings = &source.settings;
    let direction = direction.as_dvec3().try_normalize().ok_or("its light has no direction")?;
    let camera = &around.view.camera;
    let axes = camera.view().as_dmat4();
    let (low, _) = extent(&axes, all_corners(around));
    if !(low.z < 0.0) {
        return Err("nothing that casts or receives is in front of the camera".into());
    }
    // The end moves in steps, so that sizes stay the same over most motions.
    let step = 2.0_f64.sqrt();
    let seen = step.powf((-low.z).log(step).ceil());
    let far = f64::from(camera.far).min(seen);
    let near = f64::from(camera.near).max(NEAREST * far).min(0.5 * far);
    let count = settings.cascades as usize;
    let lambda = f64::from(settings.split);
    let end = |i: usize| {
        let share = i as f64 / count as f64;
        lambda * near * (far / near).powf(share) + (1.0 - lambda) * (near + share * (far - near))
    };
    let ends: Vec<f64> = (1..=count).map(end).collect();
    let aspect = f64::from(around.view.aspect());
    let reach = |depth: f64| match camera.projection {
        Projection::Perspective { fov_y } => depth * (0.5 * f64::from(fov_y)).tan(),
        Projection::Orthographic { height } => 0.5 * f64::from(height),
    };
    let size = f64::from(settings.resolution);
    let turned = looking(DVec3::ZERO, direction, around.up.axis().as_dvec3());
    let (scene_low, scene_high) = extent(&turned, all_corners(around));
    let slack = 1e-3 * (scene_high.z - scene_low.z).max(1e-6);
    let (eye, forward) = (camera.position.as_dvec3(), -axes.row(2).truncate());
    let views = (0..count).map(|i| {
        let (begin, end) = (if i == 0 { near } else { ends[i - 1] * (1.0 - f64::from(settings.blend)) }, ends[i]);
        let half_diagonal = |depth: f64| reach(depth) * (1.0 + aspect * aspect).sqrt();
        // The centre on the axis from which the near and the far corners are equally far.
        let (r0, r1) = (half_diagonal(begin), half_diagonal(end));
        let middle = (0.5 * (begin + end) + 0.5 * (r1 * r1 - r0 * r0) / (end - begin)).clamp(begin, end);
        let radius = (end - middle).hypot(r1).max((middle - begin).hypot(r0));
        let margin = f64::from(settings.radius) + 2.0;
        let texel = 2.0 * radius / (size - 2.0 * margin).max(1.0);
        let center = turned.transform_point3(eye + forward * middle);
        let snapped = |c: f64| (c / texel).round() * texel;
        let view = DMat4::from_translation(DVec3::new(-snapped(center.x), -snapped(center.y), 0.0)) * turned;
        MapView::orthographic(view, texel * size, -scene_high.z - slack, -scene_low.z + slack, size)
    });
    Ok(Placement { views: views.collect(), perspective: false, origin: -direction, ends })
}
