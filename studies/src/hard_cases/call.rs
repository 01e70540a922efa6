//! Calls of the kernels' functions: how arguments and results stand in system memory, for the driver
//! in `driver.c`.

use super::catalogue::Case;
use super::functions::{COUNT, FUNCTIONS, Function, MATH, MATH_FUNCTIONS, TEXTURE};
use srp_runtime::memory::BASE;
use std::collections::BTreeMap;

/// Calls to be run together, and where in system memory everything stands.
pub(super) struct Calls {
    /// For each function of the driver, the words of its inputs, 4 words a `float4`.
    inputs: Vec<Vec<u32>>,
    /// For each call its function, and its place among those of the same number.
    calls: Vec<(&'static Function, usize)>,
    /// The functions of `math.h` among them, a bit each.
    math: u32,
    /// Other data in memory, each item at a multiple of 64 bytes behind the table.
    data: Vec<u8>,
}

/// Bytes of the table at the start of memory.
const TABLE: usize = (COUNT * 16).next_multiple_of(64);

impl Calls {
    pub(super) fn new() -> Calls {
        Calls {
            inputs: vec![Vec::new(); COUNT],
            calls: Vec::new(),
            math: 0,
            data: Vec::new(),
        }
    }

    /// Puts words into memory and says where they are.
    pub(super) fn place(&mut self, words: &[u32]) -> u32 {
        let address = BASE + (TABLE + self.data.len()) as u32;
        let bytes = words.iter().flat_map(|w| w.to_le_bytes());
        self.data.extend(bytes);
        self.data.resize(self.data.len().next_multiple_of(64), 0);
        address
    }

    /// Adds a call with these arguments, and says which it is.
    pub(super) fn add(&mut self, function: &'static Function, arguments: &[[u32; 4]]) -> usize {
        assert_eq!(
            arguments.len(),
            function.arguments.len(),
            "{}",
            function.name
        );
        let inputs = &mut self.inputs[function.number];
        let place = inputs.len() / (4 * arguments.len());
        inputs.extend(arguments.iter().flatten());
        self.calls.push((function, place));
        self.calls.len() - 1
    }

    /// Adds the call of a case.
    pub(super) fn add_case(&mut self, case: &Case, function: &'static Function) -> usize {
        let mut arguments: Vec<[u32; 4]> =
            function.arguments.iter().map(|a| case.words(a)).collect();
        match function.number {
            MATH => {
                let number = MATH_FUNCTIONS.iter().position(|f| *f == case.call);
                let number = number.unwrap_or_default() as u32;
                self.math |= 1 << number;
                arguments[0][2] = number;
            }
            TEXTURE => arguments[0][3] = self.texture(case),
            _ => {}
        }
        self.add(function, &arguments)
    }

    /// Places the texture of a case, `size` its width, height, whether it clamps, and its smaller levels; and
    /// says where its descriptor is. 0 without a size: no texture.
    fn texture(&mut self, case: &Case) -> u32 {
        let [width, height, clamp, levels] = case.floats("size").map(|x: f32| x as u32);
        if width == 0 {
            return 0;
        }
        let mut texels = Vec::new();
        for level in 0..=levels {
            let [width, height] = [width, height].map(|side| (side >> level).max(1));
            let across = width.div_ceil(4);
            let start = texels.len();
            texels.resize(start + 16 * (across * height.div_ceil(4)) as usize, 0);
            for y in 0..height {
                for x in 0..width {
                    let at = 16 * (y / 4 * across + x / 4) + 4 * (y % 4) + x % 4;
                    texels[start + at as usize] = texel(level, x, y);
                }
            }
        }
        let address = self.place(&texels);
        self.place(&[address, width, height, clamp | levels << 8])
    }

    /// The definitions with which a driver has these functions and no other.
    pub(super) fn defines(&self) -> [(String, String); 2] {
        let is_called = |number: usize| u32::from(!self.inputs[number].is_empty());
        let called = (0..COUNT).fold(0, |all, number| all | is_called(number) << number);
        [("SRP_CALLED", called), ("SRP_MATH_CALLED", self.math)]
            .map(|(name, bits)| (name.to_owned(), format!("{bits:#x}u")))
    }

    /// System memory before the driver runs.
    pub(super) fn memory(&self) -> Vec<u8> {
        let mut memory = vec![0; TABLE];
        memory.extend_from_slice(&self.data);
        for (number, inputs) in self.inputs.iter().enumerate() {
            let Some(function) = FUNCTIONS.iter().find(|f| f.number == number) else {
                continue;
            };
            let count = inputs.len() / (4 * function.arguments.len());
            let start = memory.len();
            memory.extend(inputs.iter().flat_map(|w| w.to_le_bytes()));
            let results = memory.len();
            memory.resize(results + 16 * function.results * count, 0);
            memory.resize(memory.len().next_multiple_of(64), 0);
            let row = [count as u32, BASE + start as u32, BASE + results as u32, 0];
            let bytes: Vec<u8> = row.iter().flat_map(|w| w.to_le_bytes()).collect();
            memory[16 * number..16 * number + 16].copy_from_slice(&bytes);
        }
        memory
    }

    /// The addresses of the words that each call gives, by the table in system memory.
    pub(super) fn places(&self, memory: &[u8]) -> Vec<Vec<u32>> {
        let places = |&(function, place): &(&Function, usize)| {
            let results = word(memory, 16 * function.number + 8);
            let start = results + (16 * function.results * place + 4 * function.first) as u32;
            (0..function.words).map(|i| start + 4 * i as u32).collect()
        };
        self.calls.iter().map(places).collect()
    }

    /// The words that each call gave, from system memory after the driver ran.
    pub(super) fn results(&self, memory: &[u8]) -> Vec<Vec<u32>> {
        let of_call = |places: Vec<u32>| {
            let words = places
                .into_iter()
                .map(|at| word(memory, (at - BASE) as usize));
            words.collect()
        };
        self.places(memory).into_iter().map(of_call).collect()
    }
}

/// A word of system memory; 0 beyond it.
fn word(memory: &[u8], at: usize) -> u32 {
    let bytes = memory.get(at..at + 4).and_then(|b| b.try_into().ok());
    u32::from_le_bytes(bytes.unwrap_or_default())
}

/// The words of system memory by their addresses.
pub(super) fn words(memory: &[u8]) -> BTreeMap<u32, u32> {
    let all = (0..memory.len()).step_by(4);
    all.map(|at| (BASE + at as u32, word(memory, at))).collect()
}

/// The texel of a level of the catalogue's textures in column `x` and row `y`: red in the low byte.
pub(super) fn texel(level: u32, x: u32, y: u32) -> u32 {
    let byte = |n: u32| n & 255;
    let (x, y) = (x + 5 * level, y + 3 * level);
    let (red, green) = (byte(37 * x + 101 * y + 11), byte(59 * x + 17 * y + 83));
    let (blue, alpha) = (byte(x * y + 7 * x + 200), byte(0xff_ffff - 13 * x - 29 * y));
    red | green << 8 | blue << 16 | alpha << 24
}
