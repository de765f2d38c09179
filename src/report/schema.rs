//! JSON schema of `result.json`, generated from the names that the program writes.

use super::Status;
use serde_json::{Value, json};

/// The schema (draft 2020-12) of `result.json`.
pub fn result() -> String {
    let number_or_null = json!({"type": ["number", "null"]});
    let status: Vec<Value> = [Status::Ok, Status::Unreliable, Status::UpperBound, Status::NotAvailable]
        .iter()
        .map(|s| serde_json::to_value(s).unwrap_or(Value::Null))
        .collect();
    let figure = json!({
        "type": "object",
        "additionalProperties": false,
        "required": ["name", "value", "error", "unit", "status"],
        "properties": {
            "name": {"type": "string", "description": "stable name, see docs/notation.md"},
            "wavelength_nm": {"type": "number", "exclusiveMinimum": 0},
            "polar_deg": {"type": "number", "minimum": 0, "maximum": 180},
            "azimuth_deg": {"type": "number"},
            "component": {"type": "string"},
            "value": number_or_null,
            "error": {"type": ["number", "null"], "minimum": 0},
            "unit": {"type": "string"},
            "status": {"enum": status},
            "note": {"type": "string"},
        },
    });
    let share = json!({
        "type": "object",
        "additionalProperties": false,
        "required": ["value", "error"],
        "properties": {"value": {"type": "number"}, "error": {"type": "number", "minimum": 0}},
    });
    let effect = json!({
        "type": "object",
        "additionalProperties": false,
        "required": ["on", "why"],
        "properties": {"on": {"type": "boolean"}, "why": {"type": "string"}},
    });
    let memory = json!({
        "type": "object",
        "additionalProperties": false,
        "required": ["bodies", "segments", "largest_bytes", "pockets"],
        "properties": {
            "bodies": {"type": "number", "minimum": 0},
            "segments": {"type": "number", "minimum": 0},
            "largest_bytes": {"type": "integer", "minimum": 0},
            "pockets": {"type": "integer", "minimum": 0},
        },
    });
    let voxels = json!({
        "type": "object",
        "additionalProperties": false,
        "required": ["passed", "forced"],
        "properties": {
            "passed": {"type": "number", "minimum": 0},
            "forced": {"type": "number", "minimum": 0},
        },
    });
    let schema = json!({
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "LightPro result.json",
        "type": "object",
        "additionalProperties": false,
        "required": ["lightpro", "scene", "complete", "histories", "figures", "ledger", "effects"],
        "properties": {
            "lightpro": {"type": "string", "description": "version of the program"},
            "scene": {"type": "string"},
            "complete": {"type": "boolean", "description": "false: stopped before its end"},
            "histories": {"type": "integer", "minimum": 0, "description": "per wavelength group"},
            "figures": {"type": "array", "items": figure},
            "ledger": {"type": "object", "additionalProperties": share},
            "effects": {"type": "object", "additionalProperties": effect},
            "memory": memory,
            "voxels": voxels,
        },
    });
    serde_json::to_string_pretty(&schema).unwrap_or_default() + "\n"
}
