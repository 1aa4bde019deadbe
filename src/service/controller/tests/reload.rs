//! A configuration that is read again: what is in force afterwards, and what is said of it.

use super::hand_over::status;
use super::{ScannerEvent, ServiceMessage, Stepped, Value};
use crate::config::{LoadedConfig, load};
use crate::service::replies::ReloadReply;
use tokio::sync::oneshot;

fn loaded(service: &Stepped, text: &str) -> Box<LoadedConfig> {
    let file = service.dir.path().join("again.toml");
    let store = service.store_dir();
    std::fs::write(&file, format!("store.dir = {store:?}\n{text}")).expect("written");
    Box::new(load(Some(&file), &[]).expect("valid"))
}

fn reload(service: &mut Stepped, loaded: Box<LoadedConfig>) -> ReloadReply {
    let (client, mut reply) = oneshot::channel();
    let read = ServiceMessage::ConfigRead(Ok(loaded), Some(client));
    service.controller.handle_message(read);
    reply.try_recv().expect("a reply")
}

#[test]
fn a_configuration_that_is_read_again_is_in_force_and_reported() {
    let mut service = Stepped::new("");
    service.scanner(ScannerEvent::Ready(Value::Null));
    let new = loaded(&service, "robot.name = \"rover\"\nnovelty.u_th_m = 0.007");
    let reply = reload(&mut service, new);
    assert!(reply.taken && reply.mistakes.is_empty() && reply.needs_restart.is_empty());
    assert_eq!(reply.files.len(), 1);
    assert_eq!(service.controller.settings.u_th(None), 0.007);
    let now = status(&service);
    assert_eq!(
        (now.robot.as_str(), &now.config_files),
        ("rover", &reply.files)
    );
    assert_eq!(
        (&now.config_loaded_at, &now.config_read),
        (&reply.at, &reply)
    );
    assert!(
        service
            .events()
            .contains(&"configuration reloaded".to_owned())
    );

    for (key, line) in [
        ("api.socket", "api.socket = \"/tmp/another.sock\""),
        ("log.to", "log.to = \"stderr\""),
    ] {
        let mut service = Stepped::new("");
        service.scanner(ScannerEvent::Ready(Value::Null));
        let new = loaded(&service, line);
        assert_eq!(reload(&mut service, new).needs_restart, [key]);
    }
    let mut service = Stepped::new("");
    service.scanner(ScannerEvent::Ready(Value::Null));
    let mut elsewhere = loaded(&service, "");
    elsewhere.settings.store.dir = service.dir.path().join("elsewhere");
    assert_eq!(reload(&mut service, elsewhere).needs_restart, ["store.dir"]);
}

#[test]
fn a_refused_configuration_changes_nothing_but_what_is_said_of_it() {
    let mut service = Stepped::new("");
    let before = status(&service);
    let file = service.dir.path().join("again.toml");
    std::fs::write(&file, "laser.prot = \"x\"").expect("written");
    let errors = load(Some(&file), &[]).expect_err("a mistake");
    let (client, mut reply) = oneshot::channel();
    let read = ServiceMessage::ConfigRead(Err(errors), Some(client));
    service.controller.handle_message(read);
    let reply = reply.try_recv().expect("a reply");
    assert!(!reply.taken && reply.mistakes.len() == 1, "{reply:?}");
    let now = status(&service);
    assert_eq!(
        (now.config_read, now.config_files),
        (reply, before.config_files)
    );
    let refused = |text: &String| text.starts_with("configuration not reloaded");
    assert!(service.events().iter().any(refused));
}
