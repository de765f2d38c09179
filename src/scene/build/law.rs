//! Size laws and orientation laws.

use super::{Node, Reading};
use crate::law::{Azimuth, Roll, SizeLaw, Tilt, Weighting};
use crate::scene::adapters;
use crate::scene::diagnostic::Diagnostic;

impl Reading<'_> {
    /// The law of a size, given as an attribute (one value) or as a child element, here or in the
    /// distribution file. A law measured by mass (length) is divided by x^mass (x^length) to get the
    /// law by number. `most`: largest value allowed.
    pub fn size(
        &mut self,
        e: Node<'_>,
        name: &'static str,
        mass: f64,
        length: f64,
        most: Option<f64>,
    ) -> Option<SizeLaw> {
        for (element, is_own) in [(Some(e.own), true), (e.base, false)] {
            let Some(element) = element else { continue };
            let child = element.children.iter().find(|c| c.name == name);
            if let (true, Some(c)) = (is_own, child) {
                c.used.set(true);
            }
            match (element.attribute(name), child) {
                (Some(a), Some(c)) => {
                    self.out.push(
                        Diagnostic::error(c.place, format!("`{name}` is given as a value and as a law"))
                            .other(a.name_place, "the value"),
                    );
                    return None;
                }
                (Some(_), None) => {
                    let x = e.number(name)?;
                    return self.made(adapters::constant(x), e);
                }
                (None, Some(c)) => {
                    let rule = e.rule.child(name)?.1;
                    return self.law(Node::new(c, rule), (mass, length), most);
                }
                (None, None) => {}
            }
        }
        None
    }

    /// As [`Reading::size`]; its absence is an error.
    pub fn needed_size(&mut self, e: Node<'_>, name: &'static str, mass: f64, length: f64) -> SizeLaw {
        let given = e.has(name)
            || e.own.children.iter().chain(e.base.iter().flat_map(|b| &b.children)).any(|c| c.name == name);
        if !given && !e.own.misspelt.get() {
            self.out.push(
                Diagnostic::error(e.own.place, format!("<{}> needs `{name}`", e.own.name))
                    .help(format!("as {name}=\"30 um\", or as a child <{name} law=…>")),
            );
        }
        self.size(e, name, mass, length, None).unwrap_or(SizeLaw::Constant(1.0))
    }

    fn made<T>(&mut self, law: Result<T, String>, e: Node<'_>) -> Option<T> {
        law.map_err(|why| self.error(e.own.place, why)).ok()
    }

    fn law(&mut self, e: Node<'_>, exponents: (f64, f64), most: Option<f64>) -> Option<SizeLaw> {
        let name = e.text("law")?;
        let why = format!("law `{name}`");
        let mut n = |attribute: &str| e.needed(self, attribute, &why);
        let law = match name {
            "constant" => adapters::constant(n("value")?),
            "uniform" => {
                let (lo, hi) = (n("from"), n("to"));
                adapters::uniform(lo?, hi?)
            }
            "truncated-normal" => {
                let (mean, sd, lo, hi) = (n("mean"), n("sd"), n("from"), n("to"));
                adapters::truncated_normal(mean?, sd?, lo?, hi?)
            }
            "lognormal" => {
                let (median, sigma) = (n("median"), n("sigma"));
                adapters::lognormal(median?, sigma?)
            }
            "gamma" => {
                let (mean, shape) = (n("mean"), n("shape"));
                adapters::gamma(mean?, shape?)
            }
            "weibull" => {
                let (scale, shape) = (n("scale"), n("shape"));
                adapters::weibull(scale?, shape?)
            }
            "beta" => {
                let (a, b, lo, hi) = (n("alpha"), n("beta"), n("from"), n("to"));
                adapters::beta(a?, b?, lo?, hi?)
            }
            "histogram" => {
                let (edges, weights) = self.histogram(e)?;
                adapters::histogram(edges, weights)
            }
            "mixture" => return self.mixture(e, exponents, most),
            _ => return None,
        };
        let law = self.made(law, e)?;
        if let Some(most) = most
            && adapters::upper(&law) > most
        {
            let d = Diagnostic::error(
                e.own.place,
                format!("<{}> may not exceed {most}, this law does", e.own.name),
            );
            self.out.push(d.help("take a law with bounds: uniform, truncated-normal, beta or histogram"));
            return None;
        }
        let converted = match e.text("weighted") {
            Some("mass") => adapters::from_weighted(law, Weighting::Mass, exponents.0),
            Some("length") => adapters::from_weighted(law, Weighting::Length, exponents.1),
            _ => Ok(law),
        };
        self.made(converted, e)
    }

    fn mixture(&mut self, e: Node<'_>, exponents: (f64, f64), most: Option<f64>) -> Option<SizeLaw> {
        let parts: Vec<Node<'_>> = e.children("part").collect();
        let shares: f64 = parts.iter().filter_map(|p| p.number("share")).sum();
        if parts.is_empty() || (shares - 1.0).abs() > 1e-9 {
            let d =
                Diagnostic::error(e.own.place, format!("the shares of a mixture sum to {shares}, not to 1"));
            self.out.push(d.help("<part share=\"0.3\" law=…/> for each law"));
            return None;
        }
        let mut laws = Vec::new();
        for p in parts {
            laws.push((p.number("share")?, self.law(p, exponents, most)?));
        }
        let law = adapters::mixture(laws);
        self.made(law, e)
    }

    /// Edges and weights, in attributes or in a file.
    pub fn histogram(&mut self, e: Node<'_>) -> Option<(Vec<f64>, Vec<f64>)> {
        let (edges, weights) = match e.one_of(self, &["edges", "file"], Some("the bins of its histogram"))? {
            "file" => self.histogram_file(e.attribute("file")?)?,
            _ => {
                if !e.has("weights") {
                    self.error(e.own.place, "a histogram with `edges` needs `weights`");
                }
                (e.list("edges")?, e.list("weights")?)
            }
        };
        let problem = if edges.len() != weights.len() + 1 {
            format!(
                "{} edges for {} weights: one more edge than weights is needed",
                edges.len(),
                weights.len()
            )
        } else if edges.windows(2).any(|w| w[0] >= w[1]) || edges[0] < 0.0 {
            "the edges of a histogram ascend from 0 or above".to_string()
        } else if weights.iter().any(|w| *w < 0.0) || weights.iter().sum::<f64>() <= 0.0 {
            "the weights of a histogram are ≥ 0 and not all 0".to_string()
        } else {
            return Some((edges, weights));
        };
        self.error(e.own.place, problem);
        None
    }

    /// Azimuth and tilt of the axis.
    pub fn orientation(&mut self, e: Node<'_>) -> (Azimuth, Tilt) {
        let mean = |e: Node<'_>| e.number("mean-direction").unwrap_or(0.0);
        let azimuth = match e.text("orientation") {
            Some("von-mises") => {
                let kappa = e.needed(self, "kappa", "orientation `von-mises`").unwrap_or(0.0);
                adapters::von_mises(mean(e), kappa)
            }
            Some("wrapped-cauchy") => {
                let rho = e.needed(self, "rho", "orientation `wrapped-cauchy`").unwrap_or(0.0);
                adapters::wrapped_cauchy(mean(e), rho)
            }
            Some("isotropic") => {
                if e.number("tilt").is_some_and(|t| t > 0.0) {
                    self.error(e.place("tilt"), "an isotropic axis has no law of tilt of its own");
                }
                return (Azimuth::Uniform, Tilt::Isotropic);
            }
            _ => Ok(Azimuth::Uniform),
        };
        let tilt = match e.number("tilt") {
            Some(sd) if sd > 0.0 => adapters::tilt_normal(sd),
            _ => Ok(Tilt::InPlane),
        };
        let tilt = self.made(tilt, e).unwrap_or(Tilt::InPlane);
        (self.made(azimuth, e).unwrap_or(Azimuth::Uniform), tilt)
    }

    pub fn roll(&mut self, e: Node<'_>) -> Roll {
        match e.text("roll") {
            Some("uniform") => Roll::Uniform,
            Some("normal") => {
                let sd = e.needed(self, "roll-sd", "roll `normal`").unwrap_or(1.0);
                let roll = adapters::roll_normal(sd);
                self.made(roll, e).unwrap_or(Roll::Flat)
            }
            _ => Roll::Flat,
        }
    }
}
