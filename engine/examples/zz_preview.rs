//! scratch
use glam::*;
use obvhs::{
    BvhBuildParams,
    cwbvh::builder::build_cwbvh_from_tris,
    ray::{Ray, RayHit},
    triangle::Triangle,
};
use rayon::prelude::*;
fn main() {
    let a: Vec<String> = std::env::args().collect();
    let g = gltf::Gltf::open(&a[1]).unwrap();
    let dir0 = std::path::Path::new(&a[1]).parent().unwrap();
    let b: Vec<Vec<u8>> = g
        .buffers()
        .map(|x| match x.source() {
            gltf::buffer::Source::Uri(u) => std::fs::read(dir0.join(u)).unwrap(),
            _ => g.blob.clone().unwrap(),
        })
        .collect();
    let d = g.document.clone();
    let w: usize = a[3].parse().unwrap();
    let h: usize = a[4].parse().unwrap();
    let spp: u32 = a[5].parse().unwrap();
    let mut tris = vec![];
    let mut mat = vec![];
    let mut nor = vec![];
    let mut cam = (Mat4::IDENTITY, 0.6f32);
    fn rec(n: gltf::Node<'_>, m: Mat4, f: &mut dyn FnMut(&gltf::Node<'_>, Mat4)) {
        let m = m * Mat4::from_cols_array_2d(&n.transform().matrix());
        f(&n, m);
        for c in n.children() {
            rec(c, m, f)
        }
    }
    for n in d.default_scene().unwrap().nodes() {
        rec(n, Mat4::IDENTITY, &mut |n, m| {
            if let Some(c) = n.camera() {
                if let gltf::camera::Projection::Perspective(p) = c.projection() {
                    cam = (m, p.yfov())
                }
            }
            if let Some(me) = n.mesh() {
                for p in me.primitives() {
                    let r = p.reader(|x| Some(&b[x.index()]));
                    let pos: Vec<Vec3> = r
                        .read_positions()
                        .unwrap()
                        .map(|p| m.transform_point3(Vec3::from(p)))
                        .collect();
                    let nm = Mat3::from_mat4(m).inverse().transpose();
                    let ns: Vec<Vec3> = r
                        .read_normals()
                        .unwrap()
                        .map(|p| (nm * Vec3::from(p)).normalize())
                        .collect();
                    let pb = p.material().pbr_metallic_roughness();
                    let e = Vec3::from(p.material().emissive_factor())
                        * p.material().emissive_strength().unwrap_or(1.0);
                    let c = Vec4::from(pb.base_color_factor()).xyz();
                    let id: Vec<u32> = r.read_indices().unwrap().into_u32().collect();
                    for t in id.chunks(3) {
                        tris.push(Triangle {
                            v0: pos[t[0] as usize].into(),
                            v1: pos[t[1] as usize].into(),
                            v2: pos[t[2] as usize].into(),
                        });
                        nor.push([ns[t[0] as usize], ns[t[1] as usize], ns[t[2] as usize]]);
                        mat.push((c, e, pb.metallic_factor(), pb.roughness_factor()))
                    }
                }
            }
        });
    }
    if a.len() > 6 {
        let v: Vec<f32> = a[6].split(',').map(|x| x.parse().unwrap()).collect();
        let eye = Vec3::new(v[0], v[1], v[2]);
        let to = Vec3::new(v[3], v[4], v[5]);
        let z = (eye - to).normalize();
        let x = Vec3::Y.cross(z).normalize();
        cam = (
            Mat4::from_cols(
                x.extend(0.0),
                z.cross(x).extend(0.0),
                z.extend(0.0),
                eye.extend(1.0),
            ),
            v[6].to_radians(),
        );
    }
    let sky = Vec3::new(0.42, 0.58, 0.85) * 0.9;
    let sky = if a.len() > 7 {
        let v: Vec<f32> = a[7].split(',').map(|x| x.parse().unwrap()).collect();
        Vec3::new(v[0], v[1], v[2])
    } else {
        sky
    };
    let lights: Vec<usize> = (0..tris.len())
        .filter(|&i| mat[i].1.max_element() > 0.0)
        .collect();
    let mut core = Default::default();
    let bvh = build_cwbvh_from_tris(&tris, BvhBuildParams::medium_build(), &mut core);
    let bt: Vec<_> = bvh
        .primitive_indices
        .iter()
        .map(|i| tris[*i as usize])
        .collect();
    let img: Vec<u8> = (0..w * h)
        .into_par_iter()
        .flat_map_iter(|i| {
            let (x, y) = (i % w, i / w);
            let mut s = (i as u32).wrapping_mul(747796405) ^ 2891336453;
            let mut rnd = || {
                s = s.wrapping_mul(747796405).wrapping_add(2891336453);
                let z = ((s >> ((s >> 28) + 4)) ^ s).wrapping_mul(277803737);
                (((z >> 22) ^ z) >> 8) as f32 / 16777216.0
            };
            let mut sum = Vec3::ZERO;
            for _ in 0..spp {
                let t = (cam.1 / 2.0).tan();
                let px = ((x as f32 + rnd()) / w as f32 * 2.0 - 1.0) * t * w as f32 / h as f32;
                let py = (1.0 - (y as f32 + rnd()) / h as f32 * 2.0) * t;
                let mut o = cam.0.w_axis.xyz();
                let mut dir = cam.0.transform_vector3(Vec3::new(px, py, -1.0)).normalize();
                let mut thr = Vec3::ONE;
                for b in 0..4 {
                    let ray = Ray::new_inf(o.into(), dir.into());
                    let mut hit = RayHit::none();
                    let f = bvh.ray_traverse(ray, &mut hit, |r, id| bt[id].intersect(r));
                    if !f {
                        sum += thr * sky;
                        break;
                    }
                    let p = bvh.primitive_indices[hit.primitive_id as usize] as usize;
                    let (c, e, met, rough) = mat[p];
                    if e.max_element() > 0.0 {
                        if b == 0 {
                            sum += thr * e;
                        }
                        break;
                    }
                    let tr = &tris[p];
                    let pos = o + dir * hit.t;
                    let (v0, v1, v2) = (Vec3::from(tr.v0), Vec3::from(tr.v1), Vec3::from(tr.v2));
                    let ng = (v1 - v0).cross(v2 - v0);
                    let ar = ng.length();
                    let ng = ng / ar;
                    let u = (v2 - v1).cross(pos - v1).dot(ng) / ar;
                    let v = (v0 - v2).cross(pos - v2).dot(ng) / ar;
                    let mut n =
                        (nor[p][0] * u + nor[p][1] * v + nor[p][2] * (1.0 - u - v)).normalize();
                    let g = if ng.dot(dir) > 0.0 { -ng } else { ng };
                    if n.dot(g) < 0.0 {
                        n = -n
                    }
                    o = pos + g * 1e-4;
                    if met < 0.5 {
                        // nee
                        if !lights.is_empty() {
                            let l = lights[(rnd() * lights.len() as f32) as usize];
                            let lt = &tris[l];
                            let (mut a, mut bb) = (rnd(), rnd());
                            if a + bb > 1.0 {
                                a = 1.0 - a;
                                bb = 1.0 - bb
                            }
                            let q = Vec3::from(lt.v0) * (1.0 - a - bb)
                                + Vec3::from(lt.v1) * a
                                + Vec3::from(lt.v2) * bb;
                            let ln = (Vec3::from(lt.v1) - Vec3::from(lt.v0))
                                .cross(Vec3::from(lt.v2) - Vec3::from(lt.v0));
                            let la = ln.length() / 2.0;
                            let ln = ln.normalize();
                            let d = q - o;
                            let dist = d.length();
                            let d = d / dist;
                            let cs = n.dot(d);
                            let cl = -ln.dot(d);
                            if cs > 0.0 && cl > 0.0 {
                                let mut r2 = Ray::new_inf(o.into(), d.into());
                                r2.tmax = dist * 0.999;
                                let mut h2 = RayHit::none();
                                if !bvh.ray_traverse(r2, &mut h2, |r, id| bt[id].intersect(r)) {
                                    sum += thr * c / std::f32::consts::PI
                                        * mat[l].1
                                        * cs
                                        * cl
                                        * la
                                        * lights.len() as f32
                                        / (dist * dist);
                                }
                            }
                        }
                        thr *= c;
                        let (a, r) = (rnd() * 6.2831853, rnd());
                        let (t1, t2) = n.any_orthonormal_pair();
                        dir = (t1 * a.cos() * r.sqrt()
                            + t2 * a.sin() * r.sqrt()
                            + n * (1.0 - r).sqrt())
                        .normalize();
                    } else {
                        thr *= c;
                        let (a, r) = (rnd() * 6.2831853, rnd());
                        let al = rough * rough;
                        let th = (al * al * r / (1.0 - r).max(1e-6)).sqrt().atan();
                        let (t1, t2) = n.any_orthonormal_pair();
                        let m = t1 * a.cos() * th.sin() + t2 * a.sin() * th.sin() + n * th.cos();
                        dir = dir - 2.0 * dir.dot(m) * m;
                        if dir.dot(g) <= 0.0 {
                            break;
                        }
                        // lights seen by metal
                        let ray = Ray::new_inf(o.into(), dir.into());
                        let mut h2 = RayHit::none();
                        if bvh.ray_traverse(ray, &mut h2, |r, id| bt[id].intersect(r)) {
                            let q = bvh.primitive_indices[h2.primitive_id as usize] as usize;
                            if mat[q].1.max_element() > 0.0 {
                                sum += thr * mat[q].1;
                                break;
                            }
                        }
                    }
                }
            }
            let c = sum / spp as f32;
            [c.x, c.y, c.z]
                .map(|v| {
                    let v = v / (1.0 + v * 0.15);
                    ((if v <= 0.0031308 {
                        v * 12.92
                    } else {
                        1.055 * v.powf(1.0 / 2.4) - 0.055
                    })
                    .clamp(0.0, 1.0)
                        * 255.0) as u8
                })
                .into_iter()
        })
        .collect();
    image::save_buffer(&a[2], &img, w as u32, h as u32, image::ColorType::Rgb8).unwrap();
}
