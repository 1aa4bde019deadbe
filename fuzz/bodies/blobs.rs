//! Decoders of the store's blobs: mixtures, views, raw sweeps, recorded dialogues.

use nalgebra::{Matrix3, Point3};
use patrold::devices::{Device, DialogueEnd, DialogueEntry, DialogueEntryKind, SweepDialogue};
use patrold_engine::blob::{decode_mixture, decode_view, encode_mixture, encode_view};
use patrold_engine::geometry::{Mount, RollPitchYaw, View};
use patrold_engine::mixture::{Gaussian, Mixture};
use patrold_engine::novelty::{ComponentBeams, ReferenceMixture};
use patrold_engine::scan::ScanGeometry;
use patrold_engine::sweep::{
    HeadMotion, PanSegment, PositionPoll, RawSweep, StampedScan, TimeSample, decode_raw_sweep,
    encode_raw_sweep,
};
use std::time::Duration;

pub(crate) fn run(data: &[u8]) {
    if let Ok(gamma) = decode_mixture(data) {
        assert_eq!(gamma.mixture.weights.len(), gamma.mixture.len());
        assert_eq!(gamma.beams.len(), gamma.mixture.len());
        assert!(encode_mixture(&gamma).len() <= data.len());
    }
    if let Ok(view) = decode_view("fuzzed", data) {
        assert!(24 * (view.points.len() + view.no_return.len()) <= data.len());
        assert!(decode_view("again", &encode_view(&view)).is_ok());
    }
    if let Ok(sweep) = decode_raw_sweep(data) {
        let again = encode_raw_sweep(&sweep);
        assert!(decode_raw_sweep(&again).is_ok());
    }
    if let Ok(dialogue) = SweepDialogue::from_bytes(data) {
        assert!(dialogue.entries.len() * 2 <= data.len());
        let again = SweepDialogue::from_bytes(&dialogue.to_bytes()).expect("its own bytes");
        assert_eq!(again.entries, dialogue.entries);
    }
}

fn dialogue() -> SweepDialogue {
    let entry = |ns, device, kind| DialogueEntry {
        at: Duration::from_nanos(ns),
        device,
        kind,
    };
    SweepDialogue {
        plan: vec![1, 2, 3],
        laser: vec![4],
        head: vec![5, 6],
        began_at: Duration::from_secs(5),
        end: DialogueEnd::Failed("the port was lost".to_owned()),
        entries: vec![
            entry(7, Device::Laser, DialogueEntryKind::CommandTaken),
            entry(8, Device::Laser, DialogueEntryKind::Sent(b"QT\n".to_vec())),
            entry(
                6,
                Device::Head,
                DialogueEntryKind::Received(b"* 5".to_vec()),
            ),
            entry(9, Device::Head, DialogueEntryKind::EventHandled),
        ],
    }
}

fn raw_sweep() -> RawSweep {
    let pan_segment = |motion| PanSegment {
        pan_rad: 0.5,
        motion,
        scans: vec![StampedScan {
            stamp_ms: 17_000_000,
            arrived_s: 3.25,
            values: vec![0, 20, 5600],
        }],
        polls: vec![PositionPoll {
            sent_s: 3.0,
            received_s: 3.1,
            tilt_steps: -900,
        }],
        time_samples: vec![TimeSample {
            sent_s: 1.0,
            received_s: 1.1,
            stamp_ms: 5,
        }],
    };
    let level = RollPitchYaw {
        roll_rad: 0.0,
        pitch_rad: 0.0,
        yaw_rad: 0.0,
    };
    RawSweep {
        scan_geometry: ScanGeometry {
            steps_per_turn: 1024,
            front_step: 384,
            first_step: 44,
            cluster: 1,
            dmin_mm: 20,
            dmax_mm: 5600,
            period_s: 0.1,
        },
        mount: Mount::new([0.1; 3], [0.4; 3], [0.7; 3], [1.0; 3], level),
        tilt_rad_per_step: 0.0009,
        tilt_zero_rad: 0.01,
        tilt_low_rad: -0.6,
        tilt_high_rad: 0.4,
        line_pitch_rad: 0.0087,
        time_offset_s: 0.0,
        tilt_backlash_rad: 0.0,
        pan_segments: vec![
            pan_segment(HeadMotion::Tilting {
                speed_steps_s: 97.0,
            }),
            pan_segment(HeadMotion::StepAndStare {
                tilt_steps: vec![-5],
            }),
        ],
    }
}

pub(crate) fn seeds() -> Vec<Vec<u8>> {
    let component = Gaussian {
        mean: Point3::new(1.0, 2.0, 3.0),
        covariance: Matrix3::identity(),
    };
    let mixture = Mixture {
        weights: vec![0.25, 0.75],
        components: vec![component; 2],
    };
    let beams = ComponentBeams {
        count: 40.0,
        noise_m: 0.01,
        lost_share: 0.1,
    };
    let gamma = ReferenceMixture {
        mixture,
        beams: vec![beams; 2],
    };
    let points = vec![Point3::new(1.0, 0.5, 0.25); 3];
    vec![
        encode_mixture(&gamma),
        encode_view(&View::from_points(points, Point3::origin())),
        encode_raw_sweep(&raw_sweep()),
        dialogue().to_bytes(),
    ]
}
