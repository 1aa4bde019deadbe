//! `MESSAGE_ID` of each kind of entry in the journal: random 128-bit numbers that never change (systemd.journal-fields).
//! docs/contract.md lists them.

pub(super) const VISIT_QUIET: &str = "6094e2aa5b924488927463b6dd238deb";
pub(super) const VISIT_CHANGED: &str = "aa318b0ba44545a9b5e2f2905e1f3f8b";
pub(super) const VISIT_NOT_OBSERVED: &str = "b7396f61d5f84a9ca4c972534ac9f315";
/// The disk took nothing of the visit.
pub(super) const VISIT_NOT_STORED: &str = "53422fb2a712426386b4254420ab9028";
/// The disk took the rows of the visit, not the files of its sweep.
pub(super) const EVIDENCE_NOT_STORED: &str = "dd16c7bb8375456b91dd3da465795367";
pub(super) const REFERENCE_TAKEN: &str = "dc0e309006f34df7b6e240189a5ed1e9";
pub(super) const REQUEST_REFUSED: &str = "ad41b123a30e4883aa6f7ccd2ece7421";
pub(super) const ALARM_ACKNOWLEDGED: &str = "0190b99820c046ca9e5a63f5a13c27cf";
const DEVICE_EVENT: &str = "cb4c4a75a30e4e6db249b9b52fb51253";
const STORE_EVENT: &str = "ff7ddcb4db2849978d1c1a959ecdc4eb";
const SERVICE_EVENT: &str = "1701fa61f630498981231f4b4b3fb74a";
const HEALTH_EVENT: &str = "99d32a9df0654f039bc528edfcadd7cc";

/// Of an entry of the event log.
pub(super) fn of_event(device: &str) -> &'static str {
    match device {
        "service" => SERVICE_EVENT,
        "store" => STORE_EVENT,
        "health" => HEALTH_EVENT,
        _ => DEVICE_EVENT,
    }
}

/// Of a visit with this verdict.
pub(super) fn of_verdict(verdict: &str) -> &'static str {
    match verdict {
        "quiet" => VISIT_QUIET,
        "changed" => VISIT_CHANGED,
        _ => VISIT_NOT_OBSERVED,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    const ALL: [&str; 12] = [
        VISIT_QUIET,
        VISIT_CHANGED,
        VISIT_NOT_OBSERVED,
        VISIT_NOT_STORED,
        EVIDENCE_NOT_STORED,
        REFERENCE_TAKEN,
        REQUEST_REFUSED,
        ALARM_ACKNOWLEDGED,
        DEVICE_EVENT,
        STORE_EVENT,
        SERVICE_EVENT,
        HEALTH_EVENT,
    ];

    #[test]
    fn each_kind_has_its_own_number_and_the_contract_lists_it() {
        assert_eq!(ALL.iter().collect::<BTreeSet<_>>().len(), ALL.len());
        let contract = patrold_test_support::workspace_root().join("docs/contract.md");
        let contract = std::fs::read_to_string(contract).expect("the contract");
        for id in ALL {
            let is_number = |c: char| c.is_ascii_digit() || ('a'..='f').contains(&c);
            assert!(id.len() == 32 && id.chars().all(is_number), "{id}");
            assert_eq!(contract.matches(id).count(), 1, "{id}");
        }
    }

    #[test]
    fn events_and_verdicts_have_their_kinds() {
        let events = ["laser", "ptu", "devices", "store", "service", "health"].map(of_event);
        let expected = [
            DEVICE_EVENT,
            DEVICE_EVENT,
            DEVICE_EVENT,
            STORE_EVENT,
            SERVICE_EVENT,
            HEALTH_EVENT,
        ];
        assert_eq!(events, expected);
        let visits = ["quiet", "changed", "not_observed"].map(of_verdict);
        assert_eq!(visits, [VISIT_QUIET, VISIT_CHANGED, VISIT_NOT_OBSERVED]);
    }
}
