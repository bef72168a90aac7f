//! The rows, as a file and as Markdown.

use std::fmt::Write;

use crate::Error;

/// What one program made of one mesh. Distances are in % of the diagonal of the bounding box.
#[derive(Clone, Debug)]
pub(crate) struct Row {
    pub(crate) mesh: String,
    pub(crate) triangles: usize,
    pub(crate) program: String,
    pub(crate) hulls: usize,
    pub(crate) most_vertices: usize,
    pub(crate) outside_max: f64,
    pub(crate) outside_mean: f64,
    pub(crate) uncovered_max: f64,
    pub(crate) uncovered_mean: f64,
    /// Processor time.
    pub(crate) seconds: f64,
}

impl Row {
    pub(crate) fn hausdorff(&self) -> f64 {
        self.outside_max.max(self.uncovered_max)
    }

    /// Of both ways.
    pub(crate) fn mean(&self) -> f64 {
        0.5 * (self.outside_mean + self.uncovered_mean)
    }
}

const HEADER: &str =
    "mesh,triangles,program,hulls,most_vertices,outside_max,outside_mean,uncovered_max,uncovered_mean,seconds\n";

pub(crate) fn to_csv(rows: &[Row]) -> String {
    let mut text = HEADER.to_owned();
    for row in rows {
        let Row { mesh, triangles, program, hulls, most_vertices, .. } = row;
        let Row { outside_max, outside_mean, uncovered_max, uncovered_mean, seconds, .. } = row;
        let _ = writeln!(
            text,
            "{mesh},{triangles},{program},{hulls},{most_vertices},{outside_max:.4},{outside_mean:.4},{uncovered_max:.4},{uncovered_mean:.4},{seconds:.2}"
        );
    }
    text
}

pub(crate) fn from_csv(text: &str) -> Result<Vec<Row>, Error> {
    let mut rows = Vec::new();
    for line in text.lines().skip(1) {
        let [mesh, triangles, program, hulls, most_vertices, a, b, c, d, seconds] =
            line.split(',').collect::<Vec<_>>()[..]
        else {
            return Err(format!("not ten columns: {line}").into());
        };
        rows.push(Row {
            mesh: mesh.into(),
            triangles: triangles.parse()?,
            program: program.into(),
            hulls: hulls.parse()?,
            most_vertices: most_vertices.parse()?,
            outside_max: a.parse()?,
            outside_mean: b.parse()?,
            uncovered_max: c.parse()?,
            uncovered_mean: d.parse()?,
            seconds: seconds.parse()?,
        });
    }
    Ok(rows)
}

/// The programs that the table shows, each as it is meant to be used.
const SHOWN: [&str; 5] = ["aam at CoACD's count", "coacd-0.05", "vhacd-64", "parry-128", "aam 2 %"];

/// Names of meshes, in order.
pub(crate) fn meshes(rows: &[Row]) -> Vec<&str> {
    let mut names: Vec<&str> = rows.iter().map(|row| row.mesh.as_str()).collect();
    names.dedup();
    names
}

pub(crate) fn to_markdown(rows: &[Row]) -> String {
    let mut text = String::from(
        "| mesh | triangles | program | hulls | most vertices | outside | mean | uncovered | mean | Hausdorff | mean of both | s |\n|---|---|---|---|---|---|---|---|---|---|---|---|\n",
    );
    let (mut both, mut compared) = (0, 0);
    for mesh in meshes(rows) {
        let of = |program: &str| rows.iter().find(|row| row.mesh == mesh && row.program == program);
        // Where it was not run with CoACD's number of hulls, that with the most hulls below it.
        let below = |theirs: &Row| {
            let ours = rows.iter().filter(|row| row.mesh == mesh && row.program.starts_with("aam "));
            ours.filter(|row| row.hulls <= theirs.hulls).max_by_key(|row| row.hulls)
        };
        let ours = of(SHOWN[0]).or_else(|| of(SHOWN[1]).and_then(below));
        for row in ours.into_iter().chain(SHOWN[1..].iter().filter_map(|program| of(program))) {
            let _ = writeln!(
                text,
                "| {} | {} | {} | {} | {} | {:.2} | {:.3} | {:.2} | {:.3} | {:.2} | {:.3} | {:.1} |",
                row.mesh,
                row.triangles,
                row.program,
                row.hulls,
                row.most_vertices,
                row.outside_max,
                row.outside_mean,
                row.uncovered_max,
                row.uncovered_mean,
                row.hausdorff(),
                row.mean(),
                row.seconds
            );
        }
        if let (Some(ours), Some(theirs)) = (ours, of(SHOWN[1])) {
            compared += 1;
            // What is within the third decimal is the same.
            let better = |ours: f64, theirs: f64| ours <= theirs + 5e-4;
            both += usize::from(
                ours.hulls <= theirs.hulls
                    && better(ours.hausdorff(), theirs.hausdorff())
                    && better(ours.mean(), theirs.mean()),
            );
        }
    }
    let _ = writeln!(text, "\nNo worse than CoACD in hulls, Hausdorff distance and mean: {both} of {compared} meshes.");
    for program in SHOWN {
        let of: Vec<&Row> = rows.iter().filter(|row| row.program == program).collect();
        let median = |value: fn(&Row) -> f64| {
            let mut values: Vec<f64> = of.iter().map(|row| value(row)).collect();
            values.sort_by(f64::total_cmp);
            values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
        };
        let _ = writeln!(
            text,
            "{program}: {} meshes, medians {} hulls, Hausdorff {:.2} %, mean {:.3} %, {:.1} s; slowest {:.1} s",
            of.len(),
            median(|row| row.hulls as f64),
            median(Row::hausdorff),
            median(Row::mean),
            median(|row| row.seconds),
            of.iter().map(|row| row.seconds).fold(0.0, f64::max)
        );
    }
    text
}
