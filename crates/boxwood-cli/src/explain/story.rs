//! From the events of a traversal to steps that can be told: each with its depth, and tests with what came of them.

use boxwood::inspect::Event;
use boxwood::{Aabb, Intersect, Ray, Step, Verdict};
use serde::Serialize;
use std::collections::{HashMap, HashSet};

/// What happened to a ray.
pub struct Story {
    pub steps: Vec<Told>,
    /// Where the nodes and cells lie that it speaks of.
    pub places: HashMap<u32, Aabb>,
}

/// A step with what is known of it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Told {
    /// From 1.
    pub step: usize,
    /// Of the node it happens at; a test lies one below its leaf.
    pub depth: u32,
    /// Where the ray's interval ends after it; infinite for a ray without end.
    pub t_max: f32,
    #[serde(flatten)]
    pub what: What,
}

/// What a step is.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum What {
    /// A box was held against the ray.
    Box {
        node: u32,
        min: [f32; 3],
        max: [f32; 3],
        enter: f32,
        leave: f32,
        verdict: &'static str,
    },
    /// A plane divides a node.
    Plane {
        node: u32,
        normal: [f32; 3],
        offset: f32,
        t: f32,
        near: bool,
        far: bool,
    },
    /// A node that was put aside is taken up again, or dropped.
    Resumed {
        node: u32,
        enter: f32,
        dropped: bool,
    },
    /// The primitives of a leaf come next.
    Leaf { node: u32, primitives: u32 },
    /// A primitive was tested.
    Test { primitive: u32, hits: Vec<Met> },
    /// A primitive was passed over, as it has been tested before.
    Repeated { primitive: u32 },
    /// A step that this program has no words for.
    Other,
}

/// A hit that a test found.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Met {
    pub t: f32,
    pub u: f32,
    pub v: f32,
    /// Whether it is the best so far.
    pub best: bool,
}

/// How often what happened.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Summary {
    pub boxes: usize,
    pub opened: usize,
    pub put_aside: usize,
    pub missed: usize,
    pub behind: usize,
    pub beyond: usize,
    pub planes: usize,
    /// Nodes put aside that were taken up again.
    pub resumed: usize,
    /// Nodes put aside that a hit made superfluous.
    pub dropped: usize,
    pub leaves: usize,
    pub tests: usize,
    pub repeated: usize,
    pub hits: usize,
    /// Hits that shortened the ray.
    pub shortened: usize,
}

impl Story {
    pub fn of(structure: &dyn Intersect, ray: &Ray) -> Self {
        let events = structure.explain(ray);
        let nodes = nodes(structure, &events);
        let mut steps: Vec<Told> = Vec::new();
        let mut t_max = ray.t_max;
        let mut leaf = 0;
        for event in events {
            match event {
                Event::Hit { hit, t_max: end } => {
                    // An equally near hit of a lower number is better too, and shortens nothing.
                    let found = Met {
                        t: hit.t,
                        u: hit.u,
                        v: hit.v,
                        best: end < t_max,
                    };
                    t_max = end;
                    if let Some(told) = steps.last_mut() {
                        told.t_max = end;
                        if let What::Test { hits, .. } = &mut told.what {
                            hits.push(found);
                        }
                    }
                }
                Event::Step(step) => {
                    let what = What::of(step);
                    let depth = match what.node() {
                        Some(node) => {
                            let depth = nodes.get(&node).map_or(0, |(depth, _)| *depth);
                            if matches!(what, What::Leaf { .. }) {
                                leaf = depth + 1;
                            }
                            depth
                        }
                        None => leaf,
                    };
                    steps.push(Told {
                        step: steps.len() + 1,
                        depth,
                        t_max,
                        what,
                    });
                }
                // Events that are yet to be invented.
                _ => {}
            }
        }
        let places = nodes.into_iter().map(|(node, (_, place))| (node, place));
        Self {
            steps,
            places: places.collect(),
        }
    }

    pub fn summary(&self) -> Summary {
        let mut sum = Summary::default();
        for told in &self.steps {
            match &told.what {
                What::Box { verdict, .. } => {
                    sum.boxes += 1;
                    match *verdict {
                        OPENED => sum.opened += 1,
                        ASIDE => sum.put_aside += 1,
                        MISSED => sum.missed += 1,
                        BEHIND => sum.behind += 1,
                        BEYOND => sum.beyond += 1,
                        _ => {}
                    }
                }
                What::Plane { .. } => sum.planes += 1,
                What::Resumed { dropped: true, .. } => sum.dropped += 1,
                What::Resumed { .. } => sum.resumed += 1,
                What::Leaf { .. } => sum.leaves += 1,
                What::Test { hits, .. } => {
                    sum.tests += 1;
                    sum.hits += hits.len();
                    sum.shortened += hits.iter().filter(|hit| hit.best).count();
                }
                What::Repeated { .. } => sum.repeated += 1,
                What::Other => {}
            }
        }
        sum
    }
}

pub const OPENED: &str = "opened";
pub const ASIDE: &str = "put aside";
pub const MISSED: &str = "missed";
pub const BEHIND: &str = "behind";
pub const BEYOND: &str = "beyond";

impl What {
    fn of(step: Step) -> Self {
        match step {
            Step::Box {
                node,
                bounds,
                enter,
                leave,
                verdict,
            } => Self::Box {
                node,
                min: bounds.lower.to_array(),
                max: bounds.upper.to_array(),
                enter,
                leave,
                verdict: match verdict {
                    Verdict::Opened => OPENED,
                    Verdict::Deferred => ASIDE,
                    Verdict::Missed => MISSED,
                    Verdict::Behind => BEHIND,
                    Verdict::Beyond => BEYOND,
                    _ => "",
                },
            },
            Step::Plane {
                node,
                normal,
                offset,
                t,
                near,
                far,
            } => Self::Plane {
                node,
                normal,
                offset,
                t,
                near,
                far,
            },
            Step::Resumed {
                node,
                enter,
                dropped,
            } => Self::Resumed {
                node,
                enter,
                dropped,
            },
            Step::Leaf { node, primitives } => Self::Leaf { node, primitives },
            Step::Primitive { primitive } => Self::Test {
                primitive,
                hits: Vec::new(),
            },
            Step::Repeated { primitive } => Self::Repeated { primitive },
            _ => Self::Other,
        }
    }

    /// The node that it happens at.
    pub fn node(&self) -> Option<u32> {
        match *self {
            Self::Box { node, .. }
            | Self::Plane { node, .. }
            | Self::Resumed { node, .. }
            | Self::Leaf { node, .. } => Some(node),
            _ => None,
        }
    }

    /// The box that it is about.
    pub fn bounds(&self) -> Option<Aabb> {
        match *self {
            Self::Box { min, max, .. } => Some(Aabb::new(min, max)),
            _ => None,
        }
    }
}

/// How deep, and where, the nodes lie that a ray comes by; those that a structure does not show are left out.
fn nodes(structure: &dyn Intersect, events: &[Event]) -> HashMap<u32, (u32, Aabb)> {
    let named: HashSet<u32> = events
        .iter()
        .filter_map(|event| match event {
            Event::Step(step) => What::of(*step).node(),
            _ => None,
        })
        .collect();
    let mut nodes = HashMap::new();
    structure.cells(&mut |cell| {
        if named.contains(&cell.node) {
            nodes.insert(cell.node, (cell.depth, cell.bounds));
        }
    });
    nodes
}
