//! Moving a camera by hand: orbit, look around, pan, dolly and fly. Pure arithmetic; distances in metres, angles in
//! radians, motions of the pointer in heights of the viewport.

use engine::scene::{Camera, Projection};
use glam::{Quat, Vec2, Vec3};

/// Radians of a turn for a motion across the height of the viewport.
const TURN: f32 = 3.0;
/// The camera comes no closer to looking straight up or down than this, radians.
const POLE: f32 = 0.02;
/// Distance to the pivot where nothing tells a better one.
const DISTANCE: f32 = 1.0;

/// A camera and the point that it turns around.
#[derive(Debug, Clone)]
pub struct Navigator {
    camera: Camera,
    /// From the camera along its view.
    distance: f32,
}

impl Navigator {
    /// Starts with a camera. It turns around what it is focused on.
    pub fn new(camera: Camera) -> Self {
        let distance = camera.focus_distance;
        let is_usable = distance.is_finite() && distance > 0.0;
        Self {
            distance: if is_usable { distance } else { DISTANCE },
            camera,
        }
    }

    /// The camera as it is now.
    pub fn camera(&self) -> &Camera {
        &self.camera
    }

    /// The camera, to change its lens.
    pub fn camera_mut(&mut self) -> &mut Camera {
        &mut self.camera
    }

    /// The point that it turns around.
    pub fn pivot(&self) -> Vec3 {
        self.eye() + self.forward() * self.distance
    }

    /// Turns around what is so far away from now on; the picture stays.
    pub fn set_distance(&mut self, depth: f32) {
        if depth.is_finite() && depth > 0.0 {
            self.distance = depth;
        }
    }

    /// Where it stands.
    pub fn eye(&self) -> Vec3 {
        self.camera.transform.translation.into()
    }

    fn forward(&self) -> Vec3 {
        -Vec3::from(self.camera.transform.matrix3.z_axis)
    }

    fn right(&self) -> Vec3 {
        self.camera.transform.matrix3.x_axis.into()
    }

    fn up(&self) -> Vec3 {
        self.camera.transform.matrix3.y_axis.into()
    }

    /// Turns around the pivot: to the right, the scene follows the pointer.
    pub fn orbit(&mut self, motion: Vec2) {
        let pivot = self.pivot();
        self.turn(motion * TURN);
        self.set_eye(pivot - self.forward() * self.distance);
    }

    /// Turns the camera on the spot: the scene follows the pointer.
    pub fn look(&mut self, motion: Vec2) {
        let scale = match self.camera.projection {
            // A point below the pointer stays there, nearly.
            Projection::Perspective { y_fov } => y_fov,
            Projection::Orthographic { .. } => 1.0,
        };
        self.turn(-motion * scale);
    }

    /// Moves sideways and up: what lies at the pivot's distance stays below the pointer.
    pub fn pan(&mut self, motion: Vec2) {
        let height = 2.0 * self.half_height();
        let way = self.right() * -motion.x + self.up() * motion.y;
        self.set_eye(self.eye() + way * height);
    }

    /// Comes nearer to the pivot, by a factor on the distance.
    pub fn dolly(&mut self, factor: f32) {
        if let Projection::Orthographic { y_mag } = &mut self.camera.projection {
            *y_mag = (*y_mag * factor).clamp(1e-6, 1e9);
            return;
        }
        let pivot = self.pivot();
        self.distance = (self.distance * factor).clamp(1e-6, 1e9);
        self.set_eye(pivot - self.forward() * self.distance);
    }

    /// Moves to the right, up and forward, metres. The pivot comes along.
    pub fn fly(&mut self, way: Vec3) {
        let way = self.right() * way.x + self.up() * way.y + self.forward() * way.z;
        self.set_eye(self.eye() + way);
    }

    /// Moves over level ground: to the right and forward, metres, however the camera is tilted.
    pub fn walk(&mut self, way: Vec2) {
        let level = |v: Vec3| Vec3::new(v.x, 0.0, v.z).normalize_or_zero();
        // Straight down, what is up in the picture is forward.
        let ahead = level(self.forward() + self.up() * -self.forward().y.signum());
        self.set_eye(self.eye() + level(self.right()) * way.x + ahead * way.y);
    }

    /// Stands higher by so many metres.
    pub fn rise(&mut self, metres: f32) {
        self.set_eye(self.eye() + Vec3::Y * metres);
    }

    /// Metres per second at which flying feels the same in scenes of any size.
    pub fn speed(&self) -> f32 {
        self.distance
    }

    /// Shows a box whole, from where the camera looks.
    pub fn frame(&mut self, low: Vec3, high: Vec3) {
        let radius = (0.5 * (high - low).length()).clamp(1e-4, 1e15);
        match &mut self.camera.projection {
            Projection::Perspective { y_fov } => {
                self.distance = radius * 1.05 / (*y_fov * 0.5).sin()
            }
            Projection::Orthographic { y_mag } => {
                *y_mag = radius * 1.05;
                self.distance = 2.0 * radius;
            }
        }
        self.set_eye(0.5 * (low + high) - self.forward() * self.distance);
    }

    /// Half the height of what is seen at the pivot's distance.
    fn half_height(&self) -> f32 {
        match self.camera.projection {
            Projection::Perspective { y_fov } => (0.5 * y_fov).tan() * self.distance,
            Projection::Orthographic { y_mag } => y_mag,
        }
    }

    /// Turns to the left about the vertical, and up about the camera's right; angles are those of a scene that follows.
    fn turn(&mut self, angles: Vec2) {
        let elevation = self.forward().y.clamp(-1.0, 1.0).asin();
        let limit = std::f32::consts::FRAC_PI_2 - POLE;
        // A camera that looks straight down already may stay so.
        let (low, high) = (elevation.min(-limit), elevation.max(limit));
        let pitch = (elevation - angles.y).clamp(low, high) - elevation;
        let turn = Quat::from_rotation_y(-angles.x) * Quat::from_axis_angle(self.right(), pitch);
        let matrix = glam::Mat3A::from_quat(turn) * self.camera.transform.matrix3;
        // Rounding would add up over many motions.
        let back = matrix.z_axis.normalize();
        let right = matrix.y_axis.cross(back).normalize();
        self.camera.transform.matrix3 = glam::Mat3A::from_cols(right, back.cross(right), back);
    }

    fn set_eye(&mut self, eye: Vec3) {
        if eye.is_finite() {
            self.camera.transform.translation = eye.into();
        }
    }
}

#[cfg(test)]
mod tests {
    use engine::scene::{Scene, default_camera};

    use super::*;

    fn navigator() -> Navigator {
        Navigator::new(default_camera(&Scene::default()))
    }

    fn assert_near(a: Vec3, b: Vec3) {
        assert!(
            (a - b).length() < 1e-3 * (1.0 + b.length()),
            "{a} is not {b}"
        );
    }

    fn assert_rigid(n: &Navigator) {
        let m = n.camera.transform.matrix3;
        assert!((m.determinant() - 1.0).abs() < 1e-4);
        assert!(m.x_axis.dot(m.y_axis).abs() < 1e-4 && m.y_axis.dot(m.z_axis).abs() < 1e-4);
    }

    #[test]
    fn orbiting_keeps_pivot_distance_and_horizon() {
        let mut n = navigator();
        let (pivot, distance) = (n.pivot(), n.distance);
        for i in 0..1000 {
            n.orbit(Vec2::new(0.01, 0.013 * (i as f32 * 0.1).sin()));
        }
        assert_near(n.pivot(), pivot);
        assert!(((n.eye() - pivot).length() - distance).abs() < 1e-3 * distance);
        assert!(n.right().y.abs() < 1e-3, "the horizon is level");
        assert_rigid(&n);
    }

    #[test]
    fn the_scene_follows_the_pointer() {
        // In the camera's frame, what is in front of the pivot moves to the right and down with the pointer.
        let place = |n: &Navigator, p: Vec3| n.camera.transform.inverse().transform_point3(p);
        let mut n = navigator();
        let point = n.pivot() - n.forward() * 0.3;
        let before = place(&n, point);
        n.orbit(Vec2::new(0.01, 0.01));
        let after = place(&n, point);
        assert!(after.x > before.x && after.y < before.y, "{before} {after}");
        let mut n = navigator();
        let pivot = n.pivot();
        n.pan(Vec2::new(0.5, 0.0));
        let edge = place(&n, pivot);
        assert!((edge.x / edge.z.abs() - n.half_height() / n.distance).abs() < 1e-4);
        let mut n = navigator();
        n.look(Vec2::new(0.1, 0.0));
        assert!(place(&n, pivot).x > 0.0);
    }

    #[test]
    fn a_walk_is_level() {
        let mut n = navigator();
        n.look(Vec2::new(0.2, 0.6));
        let from = n.eye();
        n.walk(Vec2::new(0.0, 2.0));
        assert!((n.eye().y - from.y).abs() < 1e-5);
        assert!((n.eye().distance(from) - 2.0).abs() < 1e-3);
        n.walk(Vec2::new(1.0, -2.0));
        assert!((n.eye().distance(from) - 1.0).abs() < 1e-3);
        n.rise(0.5);
        assert!((n.eye().y - from.y - 0.5).abs() < 1e-5);
    }

    #[test]
    fn poles_are_not_passed() {
        let mut n = navigator();
        for _ in 0..200 {
            n.orbit(Vec2::new(0.003, 0.1));
        }
        assert!(n.up().y > 0.0 && n.forward().y < -0.99);
        assert_rigid(&n);
        for _ in 0..200 {
            n.look(Vec2::new(0.0, 0.1));
        }
        assert!(n.up().y > 0.0 && n.forward().y > 0.99);
    }

    #[test]
    fn dolly_and_flight_go_where_they_should() {
        let mut n = navigator();
        let (pivot, distance) = (n.pivot(), n.distance);
        n.dolly(0.5);
        assert_near(n.pivot(), pivot);
        assert!((n.distance - 0.5 * distance).abs() < 1e-5);
        n.fly(Vec3::new(0.0, 0.0, 0.5 * distance));
        assert_near(n.eye(), pivot);
        n.frame(Vec3::splat(-2.0), Vec3::splat(2.0));
        assert_near(n.pivot(), Vec3::ZERO);
        n.dolly(f32::NAN);
        n.fly(Vec3::splat(f32::INFINITY));
        assert!(n.eye().is_finite());
    }
}
