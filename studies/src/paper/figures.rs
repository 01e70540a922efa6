//! Figures of Tables 3 to 6 of W.-J. Lee et al., "SGRT: a mobile GPU architecture for real-time ray
//! tracing", HPG 2013. Data to compare with.

/// The paper's figures for one scene.
pub(super) struct PaperScene {
    /// Its name, as that of the scene's file.
    pub(super) name: &'static str,
    pub(super) primary: Figures,
    pub(super) ao: Figures,
    pub(super) diffuse: Figures,
    /// Table 3, primary rays.
    pub(super) shaded: Table3,
    /// Table 3, forced specular rays.
    pub(super) forced: Table3,
    /// Table 6.
    pub(super) frames_per_second: Option<f64>,
}

/// Table 3 for one kind of rays.
pub(super) struct Table3 {
    pub(super) texture_hit: Option<f64>,
    pub(super) data_hit: f64,
    pub(super) gb_s: f64,
    pub(super) mrays: f64,
}

/// Cores and clock of Table 3.
pub(super) const CORES: f64 = 4.0;
pub(super) const SRP_MHZ: f64 = 1000.0;

/// Table 6: the other platforms, where nothing is said at 1280x720.
pub(super) const OTHERS: [(&str, u32); 4] = [
    ("a GeForce GTX 680 with OptiX, 1920x1200", 37),
    ("Intel MIC, 1920x1200", 29),
    ("the multiprocessor of Spjut et al. 2012", 9),
    ("the multiprocessor of Kim et al. 2012", 2),
];

const fn table3(texture_hit: Option<f64>, [data_hit, gb_s, mrays]: [f64; 3]) -> Table3 {
    Table3 {
        texture_hit,
        data_hit,
        gb_s,
        mrays,
    }
}

/// Table 4 for one kind of rays, and Table 5 where it has the scene.
pub(super) struct Figures {
    pub(super) steps_sp: f64,
    pub(super) steps_pp: f64,
    pub(super) mrays_sp: f64,
    pub(super) mrays_pp: f64,
    pub(super) table5: Option<Table5>,
}

/// Table 5 for one kind of rays.
#[derive(Clone, Copy)]
pub(super) struct Table5 {
    pub(super) trv_util: f64,
    pub(super) ist_util: f64,
    pub(super) trv_steps: f64,
    pub(super) ist_steps: f64,
    pub(super) trv_l1: f64,
    pub(super) trv_l2: f64,
    pub(super) ist_l1: f64,
    pub(super) gb_s: f64,
    pub(super) mrays: f64,
}

const fn table4(steps: [f64; 2], mrays: [f64; 2], table5: Option<Table5>) -> Figures {
    Figures {
        steps_sp: steps[0],
        steps_pp: steps[1],
        mrays_sp: mrays[0],
        mrays_pp: mrays[1],
        table5,
    }
}

/// In the order of the table's columns.
const fn table5(row: [f64; 9]) -> Option<Table5> {
    let [
        trv_util,
        ist_util,
        trv_steps,
        ist_steps,
        trv_l1,
        trv_l2,
        ist_l1,
        gb_s,
        mrays,
    ] = row;
    Some(Table5 {
        trv_util,
        ist_util,
        trv_steps,
        ist_steps,
        trv_l1,
        trv_l2,
        ist_l1,
        gb_s,
        mrays,
    })
}

/// Conference's AO steps are those of Table 4; Table 5 prints twice as many, and an IST step count
/// of 0.12 that does not agree with its utilisation.
pub(super) const PAPER: [PaperScene; 4] = [
    PaperScene {
        name: "sibenik",
        primary: table4(
            [61.3, 23.12],
            [27.0, 33.0],
            table5([89.0, 52.0, 23.12, 3.1, 99.0, 41.0, 99.0, 1.1, 132.0]),
        ),
        ao: table4(
            [36.55, 14.87],
            [48.0, 56.0],
            table5([92.0, 55.0, 14.87, 1.17, 99.0, 68.0, 99.0, 0.1, 222.0]),
        ),
        diffuse: table4(
            [81.62, 29.93],
            [11.0, 15.0],
            table5([49.0, 38.0, 29.93, 4.5, 72.0, 65.0, 88.0, 2.6, 61.0]),
        ),
        shaded: table3(None, [96.76, 0.5, 182.11]),
        forced: table3(None, [91.24, 1.9, 172.25]),
        frames_per_second: None,
    },
    PaperScene {
        name: "fairy",
        primary: table4(
            [70.86, 28.02],
            [22.0, 28.0],
            table5([67.0, 67.0, 28.02, 4.4, 97.0, 49.0, 99.0, 1.5, 112.0]),
        ),
        ao: table4(
            [31.53, 12.43],
            [52.0, 62.0],
            table5([61.0, 79.0, 12.43, 1.98, 94.0, 84.0, 99.0, 0.4, 249.0]),
        ),
        diffuse: table4(
            [51.72, 18.99],
            [19.0, 24.0],
            table5([49.0, 67.0, 18.99, 4.21, 73.0, 63.0, 91.0, 3.7, 97.0]),
        ),
        shaded: table3(Some(93.25), [96.87, 0.8, 175.66]),
        forced: table3(Some(81.49), [94.91, 1.9, 147.45]),
        frames_per_second: Some(34.0),
    },
    PaperScene {
        name: "ferrari",
        primary: table4([68.86, 25.52], [23.0, 29.0], None),
        ao: table4([30.64, 11.32], [54.0, 64.0], None),
        diffuse: table4([92.24, 59.2], [20.0, 25.0], None),
        shaded: table3(Some(86.12), [98.09, 0.6, 183.28]),
        forced: table3(Some(75.95), [95.71, 2.0, 163.67]),
        frames_per_second: None,
    },
    PaperScene {
        name: "conference",
        primary: table4(
            [44.66, 15.54],
            [36.0, 46.0],
            table5([78.0, 70.0, 15.54, 3.35, 99.0, 57.0, 99.0, 0.3, 184.0]),
        ),
        ao: table4(
            [17.23, 5.88],
            [99.0, 121.0],
            table5([86.0, 55.0, 5.88, 0.12, 99.0, 63.0, 99.0, 0.1, 485.0]),
        ),
        diffuse: table4(
            [43.06, 14.59],
            [33.0, 44.0],
            table5([62.0, 64.0, 14.59, 3.82, 90.0, 70.0, 96.0, 3.3, 178.0]),
        ),
        shaded: table3(None, [98.44, 0.2, 198.32]),
        forced: table3(None, [95.72, 0.8, 158.79]),
        frames_per_second: None,
    },
];
