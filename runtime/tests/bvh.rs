//! Trees of all builders over all kinds of scenes, by obvhs's validation and by our own reading of
//! what lies in memory.

mod support;

use srp_archdesc::datapath::Intersection;
use srp_archdesc::system::NodeFormat;
use srp_runtime::bvh::{
    self, Box3, Builder, Layout, MAX_DEPTH, NodeRef, PairRecord, TriangleRecord, lay_out,
};
use srp_runtime::scene::{Triangle, demo::demo};
use support::{Random, shared_scene, soup};

/// Twice the area of a triangle.
fn area(triangle: &Triangle) -> f64 {
    let [a, b, c] = triangle.positions.map(|p| p.to_array().map(f64::from));
    let edge = |to: [f64; 3]| [0, 1, 2].map(|i| to[i] - a[i]);
    let (b, c) = (edge(b), edge(c));
    let product = |i: usize, j: usize| b[i] * c[j] - b[j] * c[i];
    [(1, 2), (2, 0), (0, 1)]
        .map(|(i, j)| product(i, j))
        .map(f64::abs)
        .into_iter()
        .sum()
}

/// Every triangle that has an area stands in exactly one leaf, inside all boxes above it; no other stands in one.
fn check_layout(triangles: &[Triangle], bvh: &bvh::Bvh, layout: Layout) {
    let image = lay_out(bvh, triangles, layout);
    assert_eq!(image, lay_out(bvh, triangles, layout));
    let mut seen = vec![false; triangles.len()];
    let (node_bytes, triangle_bytes) = (layout.node_bytes as usize, layout.triangle_bytes as usize);
    let mut open: Vec<(NodeRef, [[f32; 3]; 2])> = Vec::new();
    let everything = [[f32::NEG_INFINITY; 3], [f32::INFINITY; 3]];
    open.extend(image.root.map(|root| (root, everything)));
    while let Some((node, [lo, hi])) = open.pop() {
        if !node.is_leaf() {
            assert!(node.index.is_multiple_of(2), "siblings share a line");
            let bytes = &image.nodes[node.index as usize * node_bytes..];
            let pair = PairRecord::read(bytes, node_bytes, layout.node_format);
            for side in 0..2 {
                for axis in 0..3 {
                    assert!(pair.min[side][axis] >= lo[axis] && pair.max[side][axis] <= hi[axis]);
                }
                open.push((pair.child[side], [pair.min[side], pair.max[side]]));
            }
            continue;
        }
        for i in node.index..node.index + node.count {
            let bytes = &image.triangles[i as usize * triangle_bytes..];
            let record = TriangleRecord::read(bytes);
            let triangle = &triangles[record.primitive() as usize];
            let test = layout.intersection;
            assert_eq!(
                record,
                TriangleRecord::of(triangle, record.primitive(), test)
            );
            assert!(!std::mem::replace(
                &mut seen[record.primitive() as usize],
                true
            ));
            for vertex in triangle.positions {
                for axis in 0..3 {
                    assert!((lo[axis]..=hi[axis]).contains(&vertex[axis]));
                }
            }
        }
    }
    for (seen, triangle) in seen.iter().zip(triangles) {
        assert_eq!(*seen, area(triangle) > 0.0);
    }
}

#[test]
fn trees_are_valid_and_the_same_every_time() {
    let mut random = Random::new(11);
    let mut scenes = vec![
        ("demo".to_owned(), demo().triangles),
        ("soup".to_owned(), soup(&mut random, 3000)),
    ];
    for name in [
        "cornell/CornellBox-Mirror.obj",
        "cornell/CornellBox-Sphere.obj",
        "sibenik/sibenik.obj",
    ] {
        scenes.extend(shared_scene(name).map(|s| (name.to_owned(), s.triangles)));
    }
    for (name, triangles) in &scenes {
        let boxes: Vec<Box3> = triangles.iter().map(Box3::of).collect();
        let mut costs = Vec::new();
        for builder in Builder::ALL {
            for max_leaf in [1, 4] {
                let options = bvh::Options {
                    builder,
                    max_leaf,
                    traversal_cost: 1.0,
                    view: None,
                };
                let bvh = bvh::build(triangles, &options);
                bvh.tree.validate(&boxes, false, true);
                assert!(bvh.depth() <= MAX_DEPTH, "{name}");
                assert!(builder == Builder::Best || bvh.builder == builder, "{name}");
                let leaves = bvh.tree.nodes.iter().map(|n| n.prim_count);
                assert!(leaves.max() <= Some(max_leaf));
                let again = bvh::build(triangles, &options);
                assert!(bvh.sah_cost(1.0) == again.sah_cost(1.0));
                for (node_format, node_bytes, triangle_bytes, intersection) in [
                    (NodeFormat::F32, 32, 48, Intersection::AnchorWaldScaled),
                    (NodeFormat::F32, 64, 64, Intersection::Woop),
                    (NodeFormat::F16, 20, 48, Intersection::AnchorWald),
                    (NodeFormat::Q8, 24, 48, Intersection::Wald),
                ] {
                    check_layout(
                        triangles,
                        &bvh,
                        Layout {
                            node_format,
                            node_bytes,
                            triangle_bytes,
                            intersection,
                        },
                    );
                }
                costs.push(bvh.sah_cost(1.0));
            }
        }
        // Reinsertion improves what the sweep has built, and the best is one of them.
        let [_, best, _, swept, _, reinserted, _, clustered] = costs[..] else {
            unreachable!("two trees of each builder")
        };
        assert!(reinserted <= swept * 1.001, "{name}: {costs:?}");
        assert!([swept, reinserted, clustered].contains(&best), "{name}");
    }
}

#[test]
fn shared_scenes_have_their_triangles() {
    for (name, count, materials) in [
        ("sibenik/sibenik.obj", 73_564, 15),
        ("lamborghini/lamborghini.obj", 145_917, 46),
        ("bunny/stanford-bunny.obj", 69_451, 1),
        ("cornell/CornellBox-Original.obj", 36, 9),
        ("cornell/CornellBox-Water.obj", 7_088, 10),
    ] {
        if let Some(scene) = shared_scene(name) {
            assert_eq!(scene.triangles.len(), count, "{name}");
            assert_eq!(scene.materials.len(), materials, "{name}");
            assert_eq!(scene.lights.len(), 1);
        }
    }
}
