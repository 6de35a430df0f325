//! Files in the real interface: those that other programs write, work that a kill left, renders, exports.

use super::acts::{click, number, press};
use super::seen::{says, texts};
use super::stage::{PINS, SHOT, Stage};
use super::window::{Window, changes, opened_with, session, settled, until, window};
use eframe::egui::{Key, Modifiers, ViewportCommand, ViewportEvent, ViewportId};
use egui_kittest::kittest::Queryable;
use pinwarp::edit::ui::Editor;
use pinwarp::edit::{EXPORTS, RunState};
use pinwarp::image::is_complete;
use std::fs;
use std::path::PathBuf;

fn text(window: &Window) -> String {
    session(window).document().text().to_owned()
}

fn saved(stage: &Stage) -> String {
    fs::read_to_string(stage.shot()).expect("there")
}

fn has(window: &Window, label: &str) -> bool {
    window.query_by_label(label).is_some()
}

/// Another program gives the shot on disk a number of samples.
fn write_samples(stage: &Stage, samples: u32) {
    let text = saved(stage);
    let old = text.lines().find(|line| line.starts_with("samples")).expect("it is told");
    fs::write(stage.shot(), text.replace(old, &format!("samples = {samples}"))).expect("written");
}

#[test]
fn a_shot_that_another_program_writes_is_read_again_and_changes_elsewhere_are_merged() {
    let (stage, mut window) = opened_with(PINS);
    let before = text(&window);
    write_samples(&stage, 5);
    until(&mut window, "it is read again", |window| text(window) == saved(&stage));
    assert!(says(&window, "read again"), "{:?}", texts(&window));
    assert!(!session(&window).document().is_dirty());
    settled(&mut window);
    press(&mut window, Modifiers::COMMAND, Key::Z);
    assert_eq!(text(&window), before);
    press(&mut window, Modifiers::COMMAND | Modifiers::SHIFT, Key::Z);
    click(&mut window, &["Mute pin a"]);
    settled(&mut window);
    write_samples(&stage, 6);
    until(&mut window, "it is merged", |window| session(window).document().shot().samples == 6);
    assert!(says(&window, "both changes are here"), "{:?}", texts(&window));
    assert!(session(&window).document().shot().layers[0].pins[0].is_muted);
    assert!(session(&window).document().is_dirty() && !saved(&stage).contains("mute"));
}

#[test]
fn a_change_in_the_same_place_is_asked_about_and_each_answer_is_followed() {
    let (stage, mut window) = opened_with(PINS);
    window.query_all_by_label("Shot").next().expect("the settings of the shot").click_accesskit();
    window.run_steps(3);
    number(&mut window, "Samples", 7.0);
    settled(&mut window);
    write_samples(&stage, 6);
    let theirs = saved(&stage);
    until(&mut window, "it is asked", |window| has(window, "Keep mine"));
    click(&mut window, &["Later"]);
    assert!(!has(&window, "Keep mine") && says(&window, "Saving asks again"), "{:?}", texts(&window));
    press(&mut window, Modifiers::COMMAND, Key::S);
    assert!(has(&window, "Keep mine"));
    assert_eq!(saved(&stage), theirs, "nothing is overwritten unasked");
    click(&mut window, &["Keep mine"]);
    assert!(session(&window).document().is_dirty() && saved(&stage) == theirs);
    press(&mut window, Modifiers::COMMAND, Key::S);
    assert!(!has(&window, "Keep mine") && saved(&stage).contains("samples = 7"), "{}", saved(&stage));
    number(&mut window, "Samples", 8.0);
    write_samples(&stage, 9);
    press(&mut window, Modifiers::COMMAND, Key::S);
    click(&mut window, &["Take the file"]);
    assert!(session(&window).document().shot().samples == 9 && !session(&window).document().is_dirty());
    press(&mut window, Modifiers::COMMAND, Key::Z);
    assert_eq!(session(&window).document().shot().samples, 8, "undo brings mine back");
}

/// What an editor leaves that is killed after a change.
fn killed(stage: &Stage) -> (PathBuf, Vec<u8>) {
    let mut window = window(&stage.state(), Some(&stage.shot()));
    click(&mut window, &["Mute pin a"]);
    let mut journals = fs::read_dir(stage.state().join("journals")).expect("a folder");
    let path = journals.next().expect("a journal").expect("readable").path();
    (stage.state().join("journals/killed.pinwarp-journal"), fs::read(path).expect("a journal"))
}

#[test]
fn left_work_stays_until_it_is_forgotten() {
    let stage = Stage::with(PINS);
    let (left, journal) = killed(&stage);
    let before = saved(&stage);
    fs::write(&left, &journal).expect("written");
    // With its shot: later, then never.
    for (answer, is_kept) in [("Later", true), ("Forget", false)] {
        let mut window = window(&stage.state(), Some(&stage.shot()));
        assert!(says(&window, "before 1 change of this shot"), "{:?}", texts(&window));
        click(&mut window, &[answer]);
        assert!(!has(&window, "Recover") && text(&window) == before);
        drop(window);
        assert_eq!(left.exists(), is_kept, "{answer}");
    }
    assert!(!has(&window(&stage.state(), Some(&stage.shot())), "Recover"));
    // On the start page.
    fs::write(&left, &journal).expect("written");
    let mut start = window(&stage.state(), None);
    assert!(says(&start, "1 change"));
    click(&mut start, &["Forget"]);
    assert!(!has(&start, "Recover") && !left.exists());
    assert_eq!(saved(&stage), before);
}

/// What the window answers to the button that closes it.
fn close(window: &mut Window) -> Vec<ViewportCommand> {
    let root = window.input_mut().viewports.get_mut(&ViewportId::ROOT).expect("the window");
    root.events.push(ViewportEvent::Close);
    window.step();
    let commands = window.output().viewport_output[&ViewportId::ROOT].commands.clone();
    window.run_steps(2);
    commands
}

#[test]
fn closing_asks_about_unsaved_work() {
    let (stage, mut window) = opened_with(PINS);
    assert!(!close(&mut window).contains(&ViewportCommand::CancelClose), "there is none");
    let before = saved(&stage);
    click(&mut window, &["Mute pin a"]);
    click(&mut window, &["a"]);
    let edited = text(&window);
    assert!(close(&mut window).contains(&ViewportCommand::CancelClose));
    // Keys are for the question.
    for key in [Key::Delete, Key::M, Key::ArrowUp] {
        press(&mut window, Modifiers::NONE, key);
    }
    press(&mut window, Modifiers::COMMAND, Key::Z);
    assert_eq!(text(&window), edited, "nothing is changed behind the question");
    press(&mut window, Modifiers::NONE, Key::Escape);
    assert!(!has(&window, "Discard") && !session(&window).selection.pins.is_empty(), "the pin is still chosen");
    assert!(close(&mut window).contains(&ViewportCommand::CancelClose));
    click(&mut window, &["Cancel"]);
    assert!(!has(&window, "Discard"));
    press(&mut window, Modifiers::NONE, Key::M);
    assert_ne!(text(&window), edited, "keys act again");
    press(&mut window, Modifiers::NONE, Key::M);
    let answered = |window: &mut Window, label: &str| {
        assert!(close(window).contains(&ViewportCommand::CancelClose));
        window.get_by_label(label).hover();
        window.step();
        window.get_by_label(label).click();
        let mut commands = Vec::new();
        for _ in 0..3 {
            window.step();
            commands.extend(window.output().viewport_output[&ViewportId::ROOT].commands.clone());
        }
        commands.contains(&ViewportCommand::Close)
    };
    assert!(answered(&mut window, "Save"));
    assert!(saved(&stage).contains("mute") && saved(&stage) == text(&window));
    let mut window = self::window(&stage.state(), Some(&stage.shot()));
    click(&mut window, &["Unmute pin a"]);
    assert!(answered(&mut window, "Discard"));
    assert!(!close(&mut window).contains(&ViewportCommand::CancelClose), "it is answered");
    drop(window);
    assert!(saved(&stage).contains("mute") && saved(&stage) != before);
    assert!(!has(&self::window(&stage.state(), Some(&stage.shot())), "Recover"), "what is discarded is not offered");
}

#[test]
fn a_render_shows_its_progress_and_leaves_whole_frames_when_it_is_cancelled() {
    let stage = Stage::new();
    let many = SHOT.replace("last = 6", "last = 60").replace("samples = 4", "samples = 64");
    fs::write(stage.shot(), many).expect("written");
    let mut window = window(&stage.state(), Some(&stage.shot()));
    settled(&mut window);
    press(&mut window, Modifiers::COMMAND, Key::R);
    let done = |window: &Window| {
        texts(window).iter().find_map(|text| text.strip_prefix("frame ")?.strip_suffix(" / 60")?.parse::<u32>().ok())
    };
    until(&mut window, "a frame is done", |window| done(window).is_some_and(|done| done > 0));
    assert!(says(&window, "frame 1: "), "its log: {:?}", texts(&window));
    click(&mut window, &["Cancel"]);
    let ended = |window: &Window| session(window).run().is_some_and(|run| run.state != RunState::Running);
    until(&mut window, "it ends", ended);
    let told = texts(&window).into_iter().find(|text| text.starts_with("Cancelled: ")).expect("it is told");
    let files: Vec<PathBuf> = fs::read_dir(stage.folder.path().join("out"))
        .expect("a folder")
        .map(|entry| entry.expect("one").path())
        .collect();
    let (frames, others): (Vec<&PathBuf>, Vec<&PathBuf>) =
        files.iter().partition(|path| path.extension().is_some_and(|ending| ending == "exr"));
    assert!(
        (1..60).contains(&frames.len()) && told.contains(&format!(" {} frames", frames.len())),
        "{told}: {frames:?}"
    );
    assert!(frames.iter().all(|frame| is_complete(frame)), "{frames:?}");
    // The previews, and nothing that is half written.
    assert!(others.iter().all(|path| path.with_extension("exr").exists()), "{others:?}");
    click(&mut window, &["Close"]);
    assert!(
        !has(&window, "Look at the frames") && says(&window, "Render: Cancelled: "),
        "the bottom line tells it, too"
    );
    // Another one goes on with the frames that are missing.
    press(&mut window, Modifiers::COMMAND, Key::R);
    until(&mut window, "it ends", ended);
    assert!(says(&window, &format!("Done: {} frames", 60 - frames.len())), "{:?}", texts(&window));
}

#[test]
fn a_double_click_on_discard_does_not_stop_what_runs() {
    let (stage, mut window) = opened_with(PINS);
    click(&mut window, &["Mute pin a"]);
    let session = window.state_mut().as_mut().and_then(Editor::session_mut).expect("a shot is open");
    let _end = session.pretend_export(&EXPORTS[0]);
    close(&mut window);
    window.run_steps(3);
    assert!(says(&window, &format!("The changes of {} are lost", stage.shot().display())));
    let discard = window.get_by_label("Discard").rect();
    click(&mut window, &["Discard"]);
    let stop = window.get_by_label("Stop and quit").rect();
    assert!(!stop.intersects(discard), "{stop:?} {discard:?}");
}

/// Whoever asked to quit need not ask again once what ran has ended, unless a reason is to be read.
#[test]
fn an_editor_that_was_told_to_quit_does_so_when_what_runs_has_ended() {
    let quits = |window: &mut Window| {
        let mut commands = Vec::new();
        for _ in 0..3 {
            window.step();
            commands.extend(window.output().viewport_output[&ViewportId::ROOT].commands.clone());
        }
        commands.contains(&ViewportCommand::Close)
    };
    let (_stage, mut window) = opened_with(PINS);
    for is_success in [false, true] {
        let session = window.state_mut().as_mut().and_then(Editor::session_mut).expect("a shot is open");
        let end = session.pretend_export(&EXPORTS[0]);
        assert!(close(&mut window).contains(&ViewportCommand::CancelClose));
        window.run_steps(3);
        assert!(has(&window, "Stop and quit") && !quits(&mut window), "it waits");
        end(is_success);
        assert_eq!(quits(&mut window), is_success);
        assert!(!has(&window, "Stop and quit"));
    }
}

#[test]
fn an_export_saves_the_shot_and_starts_the_program() {
    let (stage, mut window) = opened_with(PINS);
    click(&mut window, &["Mute pin a"]);
    click(&mut window, &["File", "Export"]);
    for name in ["Lattices (JSON)", "STMaps (EXR)", "Blender script", "glTF with shape keys", "After Effects script"] {
        assert!(has(&window, name), "{name}");
    }
    click(&mut window, &["Nuke script", "Start export"]);
    assert!(saved(&stage).contains("mute"), "what is exported is saved first");
    until(&mut window, "it ends", |window| session(window).message().is_some_and(|told| !told.contains("Exporting")));
    // The program of a test has no exports: that it is asked for one is all that can be seen here.
    assert!(session(&window).message().is_some_and(|told| told.contains("'to'")), "{:?}", session(&window).message());
    assert_eq!(changes(&window).len(), 1);
}
