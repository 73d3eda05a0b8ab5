//! World to clip space and to rays; the eye that a person moves.

use glam::{DMat4, DVec3, DVec4, Mat4, Vec3};
use sheen_solver::{Camera, SceneError, scene::check_camera};

/// Near plane as a part of the diagonal of the box around the scene: depth is reversed and floating, so it costs no
/// precision to put it far below anything that an eye gets close to.
const NEAR_OF_DIAGONAL: f64 = 1e-5;

/// A pinhole view with an orthonormal frame. Image right = `right`, image up = `up`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// Where the eye is [m].
    pub eye: Vec3,
    right: DVec3,
    up: DVec3,
    forward: DVec3,
    /// Tangent of half the vertical field of view.
    tangent: f64,
    near: f64,
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
}

/// A rectangle of an image's pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Tile {
    /// First column.
    pub x: u32,
    /// First row.
    pub y: u32,
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
}

impl View {
    /// The view of `camera` on a scene within `bounds` [m]. Errors: a camera that cannot make an image.
    pub fn new(camera: &Camera, bounds: (Vec3, Vec3)) -> Result<Self, SceneError> {
        check_camera(camera)?;
        let forward = (camera.target.as_dvec3() - camera.eye.as_dvec3()).normalize();
        let right = forward.cross(camera.up.as_dvec3()).normalize();
        let diagonal = (bounds.1.as_dvec3() - bounds.0.as_dvec3()).length();
        let near = if diagonal.is_finite() && diagonal > 0.0 {
            diagonal * NEAR_OF_DIAGONAL
        } else {
            NEAR_OF_DIAGONAL
        };
        Ok(Self {
            eye: camera.eye,
            right,
            up: right.cross(forward),
            forward,
            tangent: (f64::from(camera.fov_y_degrees).to_radians() * 0.5).tan(),
            near,
            width: camera.width,
            height: camera.height,
        })
    }

    /// The whole image as one tile.
    pub fn whole(&self) -> Tile {
        Tile {
            x: 0,
            y: 0,
            width: self.width,
            height: self.height,
        }
    }

    /// Clip space of `tile` from points relative to the eye. Depth is reversed and infinite: 1 at the near plane.
    pub fn clip_from_relative(&self, tile: Tile) -> Mat4 {
        let (width, height) = (f64::from(self.width), f64::from(self.height));
        let aspect = width / height;
        let rows = [
            self.right / (aspect * self.tangent),
            self.up / self.tangent,
            DVec3::ZERO,
            self.forward,
        ];
        let projection = DMat4::from_cols(
            DVec4::new(rows[0].x, rows[1].x, 0.0, rows[3].x),
            DVec4::new(rows[0].y, rows[1].y, 0.0, rows[3].y),
            DVec4::new(rows[0].z, rows[1].z, 0.0, rows[3].z),
            DVec4::new(0.0, 0.0, self.near, 0.0),
        );
        // The tile's middle goes to the middle of clip space, its borders to ±1.
        let scale = DVec3::new(
            width / f64::from(tile.width),
            height / f64::from(tile.height),
            1.0,
        );
        let middle_x = (2.0 * f64::from(tile.x) + f64::from(tile.width)) / width - 1.0;
        let middle_y = 1.0 - (2.0 * f64::from(tile.y) + f64::from(tile.height)) / height;
        let crop = DMat4::from_cols(
            DVec4::new(scale.x, 0.0, 0.0, 0.0),
            DVec4::new(0.0, scale.y, 0.0, 0.0),
            DVec4::new(0.0, 0.0, 1.0, 0.0),
            DVec4::new(-middle_x * scale.x, -middle_y * scale.y, 0.0, 1.0),
        );
        (crop * projection).as_mat4()
    }

    /// Unit direction through the point (`x`, `y`) of the image, in pixels from its top left corner.
    pub fn direction(&self, x: f64, y: f64) -> DVec3 {
        let (width, height) = (f64::from(self.width), f64::from(self.height));
        let right = (2.0 * x / width - 1.0) * self.tangent * width / height;
        let up = (1.0 - 2.0 * y / height) * self.tangent;
        (self.forward + self.right * right + self.up * up).normalize()
    }

    /// Distance along unit `direction` at which the near plane is crossed [m].
    pub fn near_along(&self, direction: DVec3) -> f64 {
        self.near / direction.dot(self.forward)
    }
}

/// What moves the eye.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Motion {
    /// The eye moves, the view turns about the eye.
    Fly,
    /// The eye circles a target.
    Orbit,
}

/// An eye that a person moves.
#[derive(Clone, Debug, PartialEq)]
pub struct Walker {
    /// Fly or orbit.
    pub motion: Motion,
    /// Metres a second.
    pub speed: f32,
    /// The speed that the size of the scene suggests [m/s].
    pub usual_speed: f32,
    camera: Camera,
    /// Unit; turns to the side keep to it.
    world_up: Vec3,
    /// From eye to the point that orbiting circles [m].
    distance: f32,
}

/// Angle that the view keeps from straight up and down [rad].
const POLE: f32 = 0.02;
/// A stroll through a scene takes about this long [s].
const CROSSING_S: f32 = 6.0;

impl Walker {
    /// Starts at `camera`, a valid one, in a scene within `bounds`.
    pub fn new(camera: &Camera, bounds: (Vec3, Vec3)) -> Self {
        let diagonal = (bounds.1 - bounds.0).length();
        let speed = if diagonal.is_finite() && diagonal > 0.0 {
            diagonal / CROSSING_S
        } else {
            1.0
        };
        let mut walker = Self {
            motion: Motion::Fly,
            speed,
            usual_speed: speed,
            camera: camera.clone(),
            world_up: Vec3::Y,
            distance: 1.0,
        };
        walker.jump(camera);
        walker
    }

    /// Moves to `camera`.
    pub fn jump(&mut self, camera: &Camera) {
        self.world_up = camera.up.normalize_or(Vec3::Y);
        self.distance = camera.eye.distance(camera.target);
        self.camera = camera.clone();
    }

    /// The camera as it stands, for an image of this size.
    pub fn camera(&self, width: u32, height: u32) -> Camera {
        Camera {
            width: width.max(1),
            height: height.max(1),
            ..self.camera.clone()
        }
    }

    /// Vertical field of view [degrees], to be changed within 1..170.
    pub fn fov_y_degrees(&mut self) -> &mut f32 {
        &mut self.camera.fov_y_degrees
    }

    fn forward(&self) -> Vec3 {
        (self.camera.target - self.camera.eye).normalize_or(Vec3::NEG_Z)
    }

    /// Unit vector to the image's right.
    fn right(&self) -> Vec3 {
        let right = self.forward().cross(self.world_up);
        // A camera of a file may look straight along `up` as far as f32 can tell.
        right
            .try_normalize()
            .unwrap_or_else(|| self.world_up.any_orthonormal_vector())
    }

    /// Turns by angles [rad]: to the right, and up. Flying, the view turns; orbiting, the eye circles the target.
    pub fn turn(&mut self, right: f32, up: f32) {
        let forward = self.forward();
        let turned = glam::Quat::from_axis_angle(self.world_up, -right) * forward;
        let elevation = turned.dot(self.world_up).clamp(-1.0, 1.0).asin();
        let limit = std::f32::consts::FRAC_PI_2 - POLE;
        let change = (elevation + up).clamp(-limit, limit) - elevation;
        let axis = turned
            .cross(self.world_up)
            .try_normalize()
            .unwrap_or_else(|| self.right());
        let forward = (glam::Quat::from_axis_angle(axis, change) * turned).normalize();
        match self.motion {
            Motion::Fly => self.camera.target = self.camera.eye + forward * self.distance,
            Motion::Orbit => self.camera.eye = self.camera.target - forward * self.distance,
        }
    }

    /// Moves eye and target along right, up and forward [m].
    pub fn shift(&mut self, right: f32, up: f32, forward: f32) {
        let step = self.right() * right + self.world_up * up + self.forward() * forward;
        self.camera.eye += step;
        self.camera.target = self.camera.eye + self.forward_after(step);
    }

    // Rebuilt from the direction so that eye and target never meet by rounding.
    fn forward_after(&self, step: Vec3) -> Vec3 {
        (self.camera.target + step - self.camera.eye).normalize_or(Vec3::NEG_Z) * self.distance
    }

    /// Multiplies the distance to the target; the target stays.
    pub fn dolly(&mut self, factor: f32) {
        let forward = self.forward();
        self.distance *= factor;
        self.camera.eye = self.camera.target - forward * self.distance;
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "tests")]
    use super::*;

    fn camera() -> Camera {
        Camera {
            name: "test".to_owned(),
            eye: Vec3::new(1.0, 2.0, 3.0),
            target: Vec3::new(-2.0, 0.5, -4.0),
            up: Vec3::Y,
            fov_y_degrees: 50.0,
            width: 320,
            height: 200,
        }
    }

    #[test]
    fn a_ray_and_its_projection_meet_in_every_tile() {
        let view = View::new(&camera(), (Vec3::ZERO, Vec3::ONE)).unwrap();
        for tile in [
            view.whole(),
            Tile {
                x: 64,
                y: 100,
                width: 64,
                height: 50,
            },
        ] {
            let (x, y) = (70.25, 101.75);
            let point = (view.direction(x, y) * 7.0).as_vec3();
            let clip = view.clip_from_relative(tile) * point.extend(1.0);
            let column =
                f64::from(tile.x) + f64::from(clip.x / clip.w * 0.5 + 0.5) * f64::from(tile.width);
            let row =
                f64::from(tile.y) + f64::from(0.5 - clip.y / clip.w * 0.5) * f64::from(tile.height);
            // f32 clip coordinates of some hundred pixels.
            assert!(
                (column - x).abs() < 1e-3 && (row - y).abs() < 1e-3,
                "{column} {row}"
            );
        }
    }

    #[test]
    fn image_right_is_view_cross_up() {
        let view = View::new(&camera(), (Vec3::ZERO, Vec3::ONE)).unwrap();
        let middle = view.direction(160.0, 100.0);
        let right = view.direction(200.0, 100.0) - middle;
        let expected = middle.cross(DVec3::Y);
        assert!(right.dot(expected) > 0.0);
        assert!(view.direction(160.0, 50.0).y > middle.y);
    }

    #[test]
    fn a_walker_keeps_its_distance_and_its_poles() {
        let mut walker = Walker::new(&camera(), (Vec3::ZERO, Vec3::ONE));
        let target = walker.camera.target;
        walker.motion = Motion::Orbit;
        for _ in 0..100 {
            walker.turn(0.1, 0.1);
        }
        assert_eq!(walker.camera.target, target);
        assert!((walker.camera.eye.distance(target) - walker.distance).abs() < 1e-4);
        assert!(walker.forward().y < 0.99999 && walker.forward().y > 0.99);
        walker.motion = Motion::Fly;
        let eye = walker.camera.eye;
        walker.turn(0.0, -1.0);
        walker.shift(0.0, 0.0, 2.0);
        assert!((walker.camera.eye.distance(eye) - 2.0).abs() < 1e-5);
        assert!(View::new(&walker.camera(10, 10), (Vec3::ZERO, Vec3::ONE)).is_ok());
    }
}
