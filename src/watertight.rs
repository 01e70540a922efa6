//! `srp watertight`: what each triangle test loses, and hits that is not there.

use crate::cli::Watertight;
use crate::failure::Failure;
use crate::files::{self, Kind, read_text};
use crate::{document, interrupt, scenes, talk};
use srp_studies::watertight::{self, APART, Aim, Answers, Count, Mesh, Options, Report, Row};
use srp_toolchain::Session;
use srp_toolchain::envelope::About;
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::Path;

/// Runs `srp watertight`.
pub(crate) fn run(args: &Watertight) -> Result<(), Failure> {
    let arch = args.machine.read()?;
    let mut session = talk::session();
    session.threads = args.threads.unwrap_or(session.threads);
    let options = Options {
        rays: args.rays,
        seed: args.seed,
    };
    let meshes = meshes(args, &session)?;
    if let Some(folder) = &args.export {
        return interrupt::looked_for(|| export(folder, &meshes, options, &session));
    }
    let others = args.beside.iter().map(|folder| answers(folder, &meshes));
    let others: Vec<Answers> = others.collect::<Result<_, _>>()?;
    let measured =
        interrupt::looked_for(|| watertight::measure(&arch, &meshes, options, &others, &session));
    let report = measured?;
    if args.json {
        let json = document::json(About::machine(&arch), &report)?;
        return Ok(talk::print(json)?);
    }
    let mut out = String::new();
    text(&mut out, &report, &meshes, args).expect("writing to a String does not fail");
    Ok(talk::print(out)?)
}

/// The meshes of the command line: those of files, or ours.
fn meshes(args: &Watertight, session: &Session<'_>) -> Result<Vec<Mesh>, Failure> {
    if args.scenes.is_empty() {
        let mesh = args.mesh.as_deref();
        return watertight::meshes(mesh).ok_or_else(|| {
            let all = watertight::meshes(None).unwrap_or_default();
            let names: Vec<&str> = all.iter().map(Mesh::name).collect();
            let name = mesh.unwrap_or_default();
            Failure::Usage(format!(
                "no mesh is named `{name}`; there are {}",
                names.join(", ")
            ))
        });
    }
    let mut named: BTreeMap<String, &Path> = BTreeMap::new();
    let mut meshes = Vec::new();
    for path in &args.scenes {
        let name = path.file_stem().unwrap_or(path.as_os_str());
        let name = name.to_string_lossy().into_owned();
        if let Some(other) = named.insert(name.clone(), path) {
            return Err(Failure::Usage(format!(
                "{} and {} are both named `{name}`: a mesh is named as its file, so that one needs another name",
                other.display(),
                path.display()
            )));
        }
        let scene = scenes::read(Some(path), None, session)?;
        meshes.push(Mesh::of(&name, scene.triangles).ok_or_else(|| {
            let path = path.display();
            Failure::message(format!("{path}: it has no triangle that a ray could meet"))
        })?);
    }
    Ok(meshes)
}

/// Writes the meshes and rays to a folder, one mesh after the other: many rays are long texts.
fn export(
    folder: &Path,
    meshes: &[Mesh],
    options: Options,
    session: &Session<'_>,
) -> Result<(), Failure> {
    files::make_folder(folder)?;
    for mesh in meshes {
        interrupt::end_if_requested()?;
        let exported = watertight::export(mesh, options, session)?;
        let path = |ending: &str| folder.join(format!("{}.{ending}", exported.name));
        files::write_once(&path("obj"), exported.obj.as_bytes())?;
        files::write_once(&path("rays"), exported.rays.as_bytes())?;
    }
    Ok(())
}

/// The answers of another ray tracer, from a folder.
fn answers(folder: &Path, meshes: &[Mesh]) -> Result<Answers, Failure> {
    let name = folder.file_name().unwrap_or(folder.as_os_str());
    let of_mesh = |mesh: &Mesh| {
        let path = folder.join(format!("{}.hits", mesh.name()));
        let text = read_text(&path, Kind::Answers)?;
        let answer = |(line, word): (usize, &str)| match word.trim() {
            "1" => Ok(true),
            "0" => Ok(false),
            _ => Err(Failure::message(format!(
                "{}:{line}:1: a line is 1 where the ray hits, and 0 where it does not",
                path.display()
            ))),
        };
        (1..).zip(text.lines()).map(answer).collect()
    };
    Ok(Answers {
        name: name.to_string_lossy().into_owned(),
        hits: meshes.iter().map(of_mesh).collect::<Result<_, _>>()?,
    })
}

/// The names of the columns.
fn names(report: &Report) -> Vec<String> {
    let tests = report.tests.iter().map(|test| test.name.clone());
    tests.chain(report.others.iter().cloned()).collect()
}

fn text(out: &mut String, report: &Report, meshes: &[Mesh], args: &Watertight) -> std::fmt::Result {
    writeln!(
        out,
        "{:20} {:>5} {:>5} {:>5} {:>5} {:>9}",
        "triangle test", "ADD", "MUL", "RCP", "CMP", "mm² T&I"
    )?;
    for (number, test) in report.tests.iter().enumerate() {
        let o = test.operations;
        let own = if number == 0 { "  the machine's" } else { "" };
        writeln!(
            out,
            "{:20} {:>5} {:>5} {:>5} {:>5} {:>9.3}{own}",
            test.name, o.add, o.mul, o.rcp, o.cmp, test.mm2
        )?;
    }
    for made in &report.meshes {
        writeln!(
            out,
            "\n{}: {} triangles, {} of them without area; {} edges are a border, of one triangle",
            made.mesh, made.triangles, made.degenerate, made.borders
        )?;
    }
    let meshes: Vec<&str> = meshes.iter().map(Mesh::name).collect();
    let aimed = |row: &Row| !matches!(row.aim, Aim::Past(_));
    let names = names(report);
    for (holes, title) in [
        (
            true,
            "lost from inside, or between triangles on both sides: there is a hole",
        ),
        (
            false,
            "lost from outside, where an outline or a border may be missed by a rounding",
        ),
    ] {
        writeln!(out, "\n{title}, of so many rays that meet the mesh")?;
        head(out, "rays", &names)?;
        let wanted = |row: &&Row| aimed(row) && row.aim.finds_holes() == holes;
        for mesh in &meshes {
            let rows = || {
                report
                    .rows
                    .iter()
                    .filter(wanted)
                    .filter(|r| r.mesh == *mesh)
            };
            if rows().next().is_none() {
                continue;
            }
            let meet = rows().map(|row| row.meet).sum();
            line(out, mesh, meet, &sums(rows(), names.len()), |c| c.lost)?;
            for row in rows().filter(|_| args.all) {
                let name = format!("  {}", row.aim.name());
                line(out, &name, row.meet, &row.counts, |c| c.lost)?;
            }
        }
        let all = || report.rows.iter().filter(wanted);
        let meet = all().map(|row| row.meet).sum();
        line(out, "all", meet, &sums(all(), names.len()), |c| c.lost)?;
    }
    writeln!(
        out,
        "\nhits of so many rays that pass the mesh: of those aimed at it, which pass by a rounding, and of those past it \
         at {} of its radius",
        APART.map(|apart| format!("{apart:e}")).join(", ")
    )?;
    head(out, "rays", &names)?;
    for mesh in meshes.iter().copied().map(Some).chain([None]) {
        let rows = || {
            let all = report.rows.iter();
            all.filter(|row| mesh.is_none_or(|mesh| row.mesh == mesh))
        };
        let near = || rows().filter(|row| aimed(row));
        let pass = near().map(|row| row.rays - row.meet).sum();
        let name = mesh.unwrap_or("all");
        line(out, name, pass, &sums(near(), names.len()), |c| {
            c.false_hits
        })?;
        for aim in APART.map(Aim::Past) {
            let past = || rows().filter(|row| row.aim == aim);
            let shot = past().map(|row| row.rays).sum();
            if shot > 0 {
                let name = format!("  {}", aim.name());
                line(out, &name, shot, &sums(past(), names.len()), |c| {
                    c.false_hits
                })?;
            }
        }
    }
    Ok(())
}

/// Sums the counts of rows.
fn sums<'r>(rows: impl Iterator<Item = &'r Row>, columns: usize) -> Vec<Count> {
    let mut all = vec![Count::default(); columns];
    for row in rows {
        for (sum, count) in all.iter_mut().zip(&row.counts) {
            sum.lost += count.lost;
            sum.false_hits += count.false_hits;
        }
    }
    all
}

fn head(out: &mut String, of: &str, names: &[String]) -> std::fmt::Result {
    write!(out, "{:20} {of:>9}", "")?;
    for name in names {
        write!(out, " {name:>18}")?;
    }
    writeln!(out)
}

fn line(
    out: &mut String,
    name: &str,
    rays: u64,
    counts: &[Count],
    of: impl Fn(&Count) -> u64,
) -> std::fmt::Result {
    write!(out, "{name:20} {rays:>9}")?;
    for count in counts {
        match of(count) {
            0 => write!(out, " {:>18}", "–")?,
            n => write!(out, " {n:>18}")?,
        }
    }
    writeln!(out)
}
