//! A job template of the Open Job Description, jobtemplate-2023-09 with the extension TASK_CHUNKING
//! (github.com/OpenJobDescription/openjd-specifications).
//!
//! In: [`Plan`]. Out: JSON, which AWS Deadline Cloud and `openjd` accept in place of YAML. Frames and chunk size are
//! job parameters; tasks that are interrupted or fail are rerun and continue where they stopped.

use super::{Plan, list_of};
use crate::files::GENERATOR;
use anyhow::bail;
use serde_json::{Value, json};
use std::path::Path;

/// Maximum length of a job's name in characters.
const LONGEST_NAME: usize = 64;

/// Returns the template.
pub(super) fn template(plan: &Plan) -> anyhow::Result<String> {
    let words = [&plan.work, &plan.report, &plan.extra_arguments].into_iter().flatten();
    if let Some(word) = words.chain([&plan.program]).find(|word| word.contains("{{")) {
        bail!("'{word}': two braces begin a reference in a job template and cannot stand in a name; rename it");
    }
    let name: String =
        format!("pinwarp {}", plan.name).chars().filter(|c| !c.is_control()).take(LONGEST_NAME).collect();
    let template = json!({
        "specificationVersion": "jobtemplate-2023-09",
        "extensions": ["TASK_CHUNKING"],
        "name": name,
        "description": format!("Written by {GENERATOR}"),
        "parameterDefinitions": parameters(plan),
        "steps": [
            step("Prepare", &[], action(&prepare(plan))),
            render(plan),
            step("Report", &["Render"], action(&report(plan))),
        ],
    });
    Ok(format!("{template:#}\n"))
}

/// Returns the parameters that a submitter may change. Paths are parameters so that a farm can map them.
fn parameters(plan: &Plan) -> Value {
    let shown = |control: &str, label: &str| json!({"control": control, "label": label});
    json!([
        {"name": "Frames", "type": "STRING", "default": list_of(&plan.frames), "minLength": 1,
         "description": "Frames, for example 1-48,60-70:2", "userInterface": shown("LINE_EDIT", "Frames")},
        {"name": "ChunkSize", "type": "INT", "default": plan.chunk, "minValue": 1,
         "description": "Number of frames per task", "userInterface": shown("SPIN_BOX", "Frames per task")},
        path("Shot", &plan.shot, plan, json!({"objectType": "FILE", "dataFlow": "IN"})),
        path("Output", &plan.folder, plan, json!({"objectType": "DIRECTORY", "dataFlow": "OUT"})),
        {"name": "Program", "type": "STRING", "default": plan.program,
         "description": "Command that starts pinwarp on the farm's machines", "userInterface": shown("LINE_EDIT", "Program")},
    ])
}

/// Returns a path parameter. Default paths are relative to the template: one that is not below it becomes a plain
/// string, which a farm does not map.
fn path(name: &str, path: &Path, plan: &Plan, kind: Value) -> Value {
    let Ok(below) = path.strip_prefix(&plan.template_folder) else {
        return json!({"name": name, "type": "STRING", "default": path});
    };
    let below = if below.as_os_str().is_empty() { Path::new(".") } else { below };
    let mut parameter = json!({"name": name, "type": "PATH", "default": below});
    for (key, value) in kind.as_object().into_iter().flatten() {
        parameter[key] = value.clone();
    }
    parameter
}

/// Runs once before all frames: layers that are solved over time are solved here, and errors in the shot are reported
/// here instead of on every machine.
fn prepare(plan: &Plan) -> Vec<String> {
    let extra_arguments = ["--openjd"].map(str::to_owned);
    with_shot_as_parameter(plan, &plan.bake).into_iter().chain(extra_arguments).collect()
}

/// Returns the arguments of the report, which reads every file completely.
fn report(plan: &Plan) -> Vec<String> {
    let extra_arguments = ["--frames", "{{Param.Frames}}", "--verify"].map(str::to_owned);
    with_shot_as_parameter(plan, &plan.report).into_iter().chain(extra_arguments).collect()
}

fn render(plan: &Plan) -> Value {
    let work = with_shot_as_parameter(plan, &plan.work).into_iter();
    let extra_arguments = ["--frames", "{{Task.Param.Frame}}", "--resume", "--openjd"].map(str::to_owned);
    let arguments: Vec<String> = work.chain(extra_arguments).chain(plan.extra_arguments.iter().cloned()).collect();
    let mut step = step("Render", &["Prepare"], action(&arguments));
    step["parameterSpace"] = json!({
        "taskParameterDefinitions": [{
            "name": "Frame",
            "type": "CHUNK[INT]",
            "range": "{{Param.Frames}}",
            "chunks": {"defaultTaskCount": "{{Param.ChunkSize}}", "rangeConstraint": "NONCONTIGUOUS"},
        }],
    });
    step
}

fn step(name: &str, after: &[&str], action: Value) -> Value {
    let mut step = json!({"name": name, "script": {"actions": {"onRun": action}}});
    if !after.is_empty() {
        step["dependencies"] = after.iter().map(|step| json!({"dependsOn": step})).collect();
    }
    step
}

/// Returns the action that runs the program. A cancelled task finishes its frames in flight.
fn action(arguments: &[String]) -> Value {
    json!({
        "command": "{{Param.Program}}",
        "args": arguments,
        "cancelation": {"mode": "NOTIFY_THEN_TERMINATE", "notifyPeriodInSeconds": 60},
    })
}

fn with_shot_as_parameter(plan: &Plan, words: &[String]) -> Vec<String> {
    let shot = plan.shot.to_string_lossy();
    let word = |word: &String| if *word == shot { "{{Param.Shot}}".to_owned() } else { word.clone() };
    words.iter().map(word).collect()
}
