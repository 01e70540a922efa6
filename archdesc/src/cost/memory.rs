//! Memories: fits to runs of CACTI 7 at 65 nm (340 K, LOP cells).

/// Area of a bit of ROM, µm²: assumed, a third of an SRAM cell.
pub const ROM_BIT: f64 = 0.30;

/// Area of a bit of SRAM with its periphery, µm²: 6.9 a byte, ±8 % from 15 to 240 KB.
pub const SRAM_BIT: f64 = 6.9 / 8.0;

/// Area of a bit of a register, µm².
pub const REGISTER_BIT: f64 = 11.0;

/// Energy of a bit of a register that is clocked, pJ.
pub const REGISTER_PJ: f64 = 0.002;

/// Energy of reading an array of so many bits, `width` of them at a time, pJ. CACTI's runs lie within
/// −23 and +22 %.
pub fn read_energy(bits: f64, width: f64) -> f64 {
    let kilobytes = (bits / 8192.0).max(1.0 / 64.0);
    0.286 * kilobytes.powf(0.59) * width.max(1.0).powf(0.46)
}

/// How long reading an array of so many bits takes, in FO4: 0.6 ns and 0.128 ns for the side of an array
/// of one KB, within 18 % of CACTI's from 0.25 to 240 KB.
pub fn access_fo4(bits: f64) -> f64 {
    let nanoseconds = 0.6 + 0.128 * (bits / 8192.0).sqrt();
    nanoseconds * 1000.0 / super::FO4_PS
}

/// Area of a register file, µm²: 0.213·(p + 1.27)² a bit for p ports, within 2 % of CACTI's from 1 to 12
/// ports. A cell grows in both directions with each port (Rixner et al., *Register organization for
/// media processing*, 2000).
pub fn file_area(registers: u32, width: u32, ports: u32) -> f64 {
    let side = f64::from(ports) + 1.27;
    f64::from(registers) * f64::from(width) * 0.213 * side * side
}

/// The factor by which an array is larger with so many ports than with one, as a register file's.
pub fn ports_factor(ports: u32) -> f64 {
    ((f64::from(ports) + 1.27) / 2.27).powi(2)
}

/// Energy of one read or write of a register file, pJ: 0.52 + 0.08·p for 64 words of 32 bits, with the
/// width, and with the root of the number of registers, along which bit lines grow.
pub fn file_energy(registers: u32, width: u32, ports: u32) -> f64 {
    let base = 0.52 + 0.08 * f64::from(ports);
    base * f64::from(width) / 32.0 * (f64::from(registers) / 64.0).sqrt()
}
