//! Every command of docs/tutorial.md, in its order, and what the page says of the results.
#![allow(missing_docs)]

use assert_cmd::Command;
use lightpro::report::RunResult;
use std::path::Path;

fn commands(page: &str) -> Vec<String> {
    let mut out = Vec::new();
    let mut inside = false;
    for line in page.lines() {
        if line.starts_with("```") {
            inside = line == "```sh";
        } else if inside {
            out.push(line.to_owned());
        }
    }
    out
}

/// Words of a command line; double quotes hold words together.
fn words(line: &str) -> Vec<String> {
    let mut out = vec![String::new()];
    let mut quoted = false;
    for c in line.chars() {
        match c {
            '"' => quoted = !quoted,
            ' ' if !quoted => out.push(String::new()),
            c => out.last_mut().unwrap().push(c),
        }
    }
    out.retain(|w| !w.is_empty());
    out
}

#[test]
fn every_command_of_the_tutorial_runs() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let page = std::fs::read_to_string(root.join("docs/tutorial.md")).unwrap();
    let list = commands(&page);
    assert!(list.len() >= 8, "{list:?}");
    let dir = tempfile::tempdir().unwrap();
    let mut said = Vec::new();
    for line in &list {
        let mut words = words(line);
        assert_eq!(words.remove(0), "lightpro", "{line}");
        for w in &mut words {
            if let Some(rest) = w.strip_prefix("results/") {
                *w = dir.path().join(rest).to_string_lossy().into_owned();
            }
        }
        if words.iter().any(|w| w == "difference") {
            std::fs::create_dir_all(dir.path().join("tutorial")).unwrap();
        }
        let done = Command::cargo_bin("lightpro").unwrap().current_dir(root).args(&words).output().unwrap();
        let out = String::from_utf8_lossy(&done.stdout).into_owned();
        assert!(done.status.success(), "{line}\n{out}\n{}", String::from_utf8_lossy(&done.stderr));
        said.push(out);
    }
    // The coarseness that `plan` prints is the one measured, within 2 %.
    let at = said[0].find("coarseness").unwrap();
    let coarseness: f64 = said[0][at..].split_whitespace().nth(1).unwrap().parse().unwrap();
    assert!((coarseness / 0.17 - 1.0).abs() < 0.02, "{coarseness}");
    assert!(said.last().unwrap().contains("delta_e_00_d65_10"));

    let base = dir.path().join("tutorial");
    let read = |name: &str| {
        RunResult::from_json(&std::fs::read_to_string(base.join(name).join("result.json")).unwrap()).unwrap()
    };
    let sheet = read("sheet");
    for name in ["brightness_r457", "opacity", "s", "k", "l_star_d65_10", "whiteness_cie_c_2"] {
        assert!(sheet.figure(name, None).unwrap().value.is_some(), "{name}");
    }
    for name in ["gloss", "mtf_half_frequency", "halftone_reflectance", "yule_nielsen_n", "path_length"] {
        assert!(read("gloss").figure(name, None).is_some_and(|f| f.error.is_some()), "{name}");
    }
    for file in ["sweep.csv", "report.html", "wall.index=1.54/result.json"] {
        assert!(base.join("index").join(file).is_file(), "{file}");
    }
    let table = std::fs::read_to_string(base.join("index/sweep.csv")).unwrap();
    assert_eq!(table.lines().count(), 4);
    assert!(table.starts_with("wall.index,brightness_r457 (%),error of brightness_r457"), "{table}");
    for file in ["brdf.csv", "angular_above.fits", "angular_below.npy", "mtf.svg"] {
        assert!(base.join("brdf/source.polar=30deg").join(file).is_file(), "{file}");
    }
    let page = std::fs::read_to_string(base.join("brdf/report.html")).unwrap();
    assert!(page.len() < 2_000_000 && page.contains("\"label\":\"60 deg\""), "{}", page.len());
    for folder in ["sheet", "brdf/source.polar=0deg", "gloss"] {
        holds_schema(&std::fs::read_to_string(base.join(folder).join("result.json")).unwrap());
    }
}

/// `result.json` against the schema, by the keywords that the schema uses.
fn holds_schema(text: &str) {
    let schema: serde_json::Value = serde_json::from_str(&lightpro::report::schema::result()).unwrap();
    let value: serde_json::Value = serde_json::from_str(text).unwrap();
    valid(&schema, &value, "result").unwrap_or_else(|e| panic!("{e}"));
}

fn valid(schema: &serde_json::Value, value: &serde_json::Value, at: &str) -> Result<(), String> {
    use serde_json::Value as V;
    let is = |name: &str| match name {
        "object" => value.is_object(),
        "array" => value.is_array(),
        "string" => value.is_string(),
        "boolean" => value.is_boolean(),
        "null" => value.is_null(),
        "number" => value.is_number(),
        "integer" => value.is_u64() || value.is_i64(),
        other => panic!("type {other}"),
    };
    for (keyword, rule) in schema.as_object().unwrap() {
        let good = match (keyword.as_str(), rule) {
            ("$schema" | "title" | "description", _) => true,
            ("type", V::String(t)) => is(t),
            ("type", V::Array(list)) => list.iter().any(|t| is(t.as_str().unwrap())),
            ("enum", V::Array(list)) => list.contains(value),
            ("minimum", m) => value.as_f64().is_none_or(|x| x >= m.as_f64().unwrap()),
            ("maximum", m) => value.as_f64().is_none_or(|x| x <= m.as_f64().unwrap()),
            ("exclusiveMinimum", m) => value.as_f64().is_none_or(|x| x > m.as_f64().unwrap()),
            ("required", V::Array(names)) => names.iter().all(|n| value.get(n.as_str().unwrap()).is_some()),
            ("properties", V::Object(own)) => {
                for (name, v) in value.as_object().into_iter().flatten() {
                    if let Some(s) = own.get(name) {
                        valid(s, v, &format!("{at}.{name}"))?;
                    }
                }
                true
            }
            ("additionalProperties", V::Bool(false)) => {
                let own = schema["properties"].as_object().unwrap();
                value.as_object().is_none_or(|o| o.keys().all(|k| own.contains_key(k)))
            }
            ("additionalProperties", s) => {
                for (name, v) in value.as_object().into_iter().flatten() {
                    valid(s, v, &format!("{at}.{name}"))?;
                }
                true
            }
            ("items", s) => {
                for (i, v) in value.as_array().into_iter().flatten().enumerate() {
                    valid(s, v, &format!("{at}[{i}]"))?;
                }
                true
            }
            (other, _) => panic!("keyword {other}"),
        };
        if !good {
            return Err(format!("{at}: {keyword} {rule} does not hold for {value}"));
        }
    }
    Ok(())
}

#[test]
fn the_schema_of_results_stands_in_the_repository_and_bites() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("schema/result.schema.json");
    let text = lightpro::report::schema::result();
    if std::env::var_os("LIGHTPRO_WRITE").is_some() {
        std::fs::write(&path, &text).unwrap();
    }
    assert_eq!(std::fs::read_to_string(&path).unwrap_or_default(), text, "LIGHTPRO_WRITE=1 renews it");
    let good = r#"{"lightpro":"0","scene":"x","complete":true,"histories":5,"ledger":{},"effects":{},
        "figures":[{"name":"r0","value":1.0,"error":null,"unit":"1","status":"ok"}]}"#;
    holds_schema(good);
    let schema: serde_json::Value = serde_json::from_str(&text).unwrap();
    for (from, to) in
        [("\"ok\"", "\"fine\""), ("\"value\":1.0,", ""), ("\"unit\"", "\"unti\""), (":5", ":-5")]
    {
        let bad: serde_json::Value = serde_json::from_str(&good.replace(from, to)).unwrap();
        assert!(valid(&schema, &bad, "result").is_err(), "{from}");
    }
}
