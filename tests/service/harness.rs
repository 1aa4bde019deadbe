//! A service in a folder of its own, with a scripted scanner in simulated scenes.

use link::Clock;
use nalgebra::Point3;
use patrold::config::{Settings, load};
use patrold::devices::Cancel;
use patrold::patrol::severity::Severity;
use patrold::service::{
    ConnectError, DeviceNoteSink, Scanner, ScannerConnector, ScannerError, ServiceCommand,
    ServiceError, ServiceParts, serve,
};
use patrold::store::SystemDisk;
use patrold_engine::scan::ScanGeometry;
use patrold_engine::sweep::{
    HeadMotion, PanSegment, PositionPoll, RawSweep, StampedScan, TimeSample,
};
use patrold_sim::world::{
    BeamFan, MountGeometry, NoiseOptions, Scene, SimulatedLaser, SimulatedRobot,
};
use serde_json::{Value, json};
use std::io::{Read as _, Write as _};
use std::os::unix::net::UnixStream;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};
use tokio::sync::mpsc;

#[derive(Debug, Clone, PartialEq)]
pub(crate) enum ScriptedSweep {
    /// Of this shipped scene.
    Scene(&'static str),
    /// The same scan again and again.
    Frozen,
    /// Covered: no beam comes back.
    Blind,
    /// The reason, and whether the devices are lost.
    Fail(&'static str, bool),
    /// Until cancelled, or the script has another sweep.
    Endless,
}

#[derive(Debug)]
pub(crate) struct Script {
    pub sweep: ScriptedSweep,
    /// Why connecting fails.
    pub absent: Option<&'static str>,
    /// Why the connected devices are lost.
    pub unplugged: Option<&'static str>,
    pub connections: usize,
    pub sweeps: u64,
    /// Connections that were dropped.
    pub released: usize,
}

#[derive(Clone)]
pub(crate) struct ScriptedScanner(Arc<Mutex<Script>>);

impl ScriptedScanner {
    pub(crate) fn new(sweep: ScriptedSweep) -> Self {
        Self(Arc::new(Mutex::new(Script {
            sweep,
            absent: None,
            unplugged: None,
            connections: 0,
            sweeps: 0,
            released: 0,
        })))
    }

    pub(crate) fn script(&self) -> MutexGuard<'_, Script> {
        self.0.lock().expect("no panic while it is locked")
    }
}

impl ScannerConnector for ScriptedScanner {
    fn connect(
        &mut self,
        _settings: &Settings,
        notes: &DeviceNoteSink,
        _cancel: &Cancel,
    ) -> Result<Box<dyn Scanner>, ConnectError> {
        let mut script = self.script();
        script.connections += 1;
        match script.absent {
            Some(reason) => Err(ConnectError {
                reason: reason.to_owned(),
                absent: true,
            }),
            None => {
                notes.report(Severity::Info, "laser", "scripted laser answers".to_owned());
                Ok(Box::new(ConnectedScanner(self.clone())))
            }
        }
    }
}

struct ConnectedScanner(ScriptedScanner);

impl Drop for ConnectedScanner {
    fn drop(&mut self) {
        self.0.script().released += 1;
    }
}

impl Scanner for ConnectedScanner {
    fn describe(&mut self) -> Value {
        json!({"laser": {"serial": "H0000000"}})
    }

    fn check_connected(&mut self) -> Result<(), ScannerError> {
        self.0.script().unplugged.map_or(Ok(()), |reason| {
            Err(ScannerError {
                reason: reason.to_owned(),
                lost: true,
            })
        })
    }

    fn sweep(
        &mut self,
        _settings: &Settings,
        _waypoint: Option<&str>,
        cancel: &Cancel,
    ) -> Result<RawSweep, ScannerError> {
        let (sweep, seed) = {
            let mut script = self.0.script();
            script.sweeps += 1;
            (script.sweep.clone(), script.sweeps)
        };
        match sweep {
            ScriptedSweep::Scene(scene) => Ok(simulated_sweep(scene, seed)),
            ScriptedSweep::Frozen => {
                let mut raw = simulated_sweep("storeroom.toml", seed);
                for pan_segment in &mut raw.pan_segments {
                    let first = pan_segment.scans[0].values.clone();
                    for scan in &mut pan_segment.scans {
                        scan.values.clone_from(&first);
                    }
                }
                Ok(raw)
            }
            ScriptedSweep::Blind => {
                let mut raw = simulated_sweep("storeroom.toml", seed);
                let segments = raw.pan_segments.iter_mut();
                for scan in segments.flat_map(|segment| &mut segment.scans) {
                    scan.values.fill(0);
                }
                Ok(raw)
            }
            ScriptedSweep::Fail(reason, lost) => Err(ScannerError {
                reason: reason.to_owned(),
                lost,
            }),
            ScriptedSweep::Endless => {
                let goes_on = || matches!(self.0.script().sweep, ScriptedSweep::Endless);
                while !cancel.is_cancelled() && goes_on() {
                    std::thread::sleep(Duration::from_millis(5));
                }
                Err(ScannerError {
                    reason: "cancelled".to_owned(),
                    lost: false,
                })
            }
        }
    }
}

const TILT_RAD_PER_STEP: f64 = 0.000_897_6;
const TILT_FROM_RAD: f64 = -0.61;
const TILT_TO_RAD: f64 = 0.44;
const LINE_PITCH_RAD: f64 = 0.0087;
const SCAN_PERIOD: Duration = Duration::from_millis(100);

/// The sweep of perfect devices in a shipped scene; `seed` is that of the noise.
fn simulated_sweep(scene: &str, seed: u64) -> RawSweep {
    let folder = patrold_test_support::workspace_root().join("config/scenes");
    let load = |file: &str| std::fs::read_to_string(folder.join(file)).map_err(|e| e.to_string());
    let scene = Scene::resolve(scene, &load).expect("a shipped scene");
    let mut laser = SimulatedLaser {
        world: Arc::new(scene.build(None).expect("builds")),
        robot: SimulatedRobot {
            map_from_base: scene.map_from_base,
            mount: MountGeometry::default(),
        },
        fan: BeamFan::default(),
        noise: NoiseOptions::seeded(seed),
    };
    let speed_rad_s = LINE_PITCH_RAD / SCAN_PERIOD.as_secs_f64();
    let start_s = 100.0;
    let duration_s = (TILT_TO_RAD - TILT_FROM_RAD) / speed_rad_s + 0.4;
    let tilt_rad = move |at_s: f64| {
        let elapsed_s = (at_s - start_s).clamp(0.0, duration_s);
        TILT_FROM_RAD - 0.2 * speed_rad_s + speed_rad_s * elapsed_s
    };
    let lines = (duration_s / SCAN_PERIOD.as_secs_f64()) as u32;
    let mut scans = Vec::new();
    for line in 0..lines {
        let start = Duration::from_secs_f64(start_s) + SCAN_PERIOD * line;
        let mut values = vec![0; 769];
        let attitude = |at: Duration| (0.0, tilt_rad(at.as_secs_f64()));
        laser.revolve(start, SCAN_PERIOD, &attitude, &mut values);
        scans.push(StampedScan {
            stamp_ms: start.as_millis() as u64,
            arrived_s: start.as_secs_f64() + 0.08,
            values: values[44..=725].to_vec(),
        });
    }
    let polls = (0..)
        .map(|i| start_s - 0.5 + f64::from(i) / 60.0)
        .take_while(|at_s| *at_s < start_s + duration_s + 0.5)
        .map(|at_s| PositionPoll {
            sent_s: at_s - 0.003,
            received_s: at_s + 0.003,
            tilt_steps: (tilt_rad(at_s) / TILT_RAD_PER_STEP).round() as i32,
        })
        .collect();
    let sample = |at_s: f64| TimeSample {
        sent_s: at_s - 0.0005,
        received_s: at_s + 0.0005,
        stamp_ms: (at_s * 1e3).round() as u64,
    };
    let pan_segment = PanSegment {
        pan_rad: 0.0,
        motion: HeadMotion::Tilting {
            speed_steps_s: speed_rad_s / TILT_RAD_PER_STEP,
        },
        scans,
        polls,
        time_samples: vec![sample(start_s - 2.0), sample(start_s + duration_s + 2.0)],
    };
    RawSweep {
        scan_geometry: ScanGeometry {
            steps_per_turn: 1024,
            front_step: 384,
            first_step: 44,
            cluster: 1,
            dmin_mm: 20,
            dmax_mm: 5600,
            period_s: SCAN_PERIOD.as_secs_f64(),
        },
        mount: Settings::defaults().mount.chain(),
        tilt_rad_per_step: TILT_RAD_PER_STEP,
        tilt_zero_rad: 0.0,
        tilt_low_rad: TILT_FROM_RAD,
        tilt_high_rad: TILT_TO_RAD,
        line_pitch_rad: LINE_PITCH_RAD,
        time_offset_s: 0.0,
        tilt_backlash_rad: 0.0,
        pan_segments: vec![pan_segment],
    }
}

/// A running service.
pub(crate) struct TestService {
    pub dir: PathBuf,
    pub scanner: ScriptedScanner,
    commands: mpsc::Sender<ServiceCommand>,
    thread: JoinHandle<Result<(), ServiceError>>,
}

#[derive(Debug)]
pub(crate) struct HttpAnswer {
    pub status: u16,
    pub head: String,
    pub body: Vec<u8>,
}

impl HttpAnswer {
    pub(crate) fn json(&self) -> Value {
        serde_json::from_slice(&self.body).expect("JSON")
    }

    /// The one line of an error.
    pub(crate) fn error(&self) -> String {
        let text = self.json()["error"].as_str().expect("an error").to_owned();
        assert_eq!(text.lines().count(), 1, "{text}");
        text
    }
}

/// Writes the configuration of a service in `dir`, with `more` at its end.
pub(crate) fn configure(dir: &Path, more: &str) {
    let text = format!(
        "store.dir = {:?}\napi.socket = {:?}\nmount.xyz_m = [0.0, 0.0, 0.05]\n{more}",
        dir.join("store"),
        dir.join("patrold.sock")
    );
    std::fs::write(dir.join("patrold.toml"), text).expect("configuration written");
}

pub(crate) fn parts(dir: &Path, scanner: &ScriptedScanner) -> ServiceParts {
    let config = dir.join("patrold.toml");
    ServiceParts {
        loaded: load(Some(&config), &[]).expect("valid configuration"),
        config_path: Some(config),
        clock: Clock::real(),
        connector: Box::new(scanner.clone()),
        disk: Arc::new(SystemDisk),
        log: None,
    }
}

impl TestService {
    pub(crate) fn start(dir: &Path, scanner: &ScriptedScanner) -> Self {
        Self::start_with(dir, scanner, parts(dir, scanner))
    }

    pub(crate) fn start_with(dir: &Path, scanner: &ScriptedScanner, parts: ServiceParts) -> Self {
        let (commands, receiver) = mpsc::channel(4);
        let thread = std::thread::spawn(move || {
            let runtime = tokio::runtime::Runtime::new().expect("runtime");
            let result = runtime.block_on(serve(parts, receiver));
            runtime.shutdown_background();
            result
        });
        let service = Self {
            dir: dir.to_owned(),
            scanner: scanner.clone(),
            commands,
            thread,
        };
        service.until("the socket listens", |service| service.socket().exists());
        service
    }

    pub(crate) fn socket(&self) -> PathBuf {
        self.dir.join("patrold.sock")
    }

    pub(crate) fn until(&self, what: &str, met: impl Fn(&Self) -> bool) {
        let deadline = Instant::now() + Duration::from_secs(60);
        while !met(self) {
            assert!(Instant::now() < deadline, "timed out: {what}");
            std::thread::sleep(Duration::from_millis(10));
        }
    }

    pub(crate) fn command(&self, command: ServiceCommand) {
        self.commands
            .blocking_send(command)
            .expect("the service runs");
    }

    pub(crate) fn request(&self, method: &str, path: &str, body: &str) -> HttpAnswer {
        let mut stream = UnixStream::connect(self.socket()).expect("the socket listens");
        write!(
            stream,
            "{method} {path} HTTP/1.1\r\nhost: x\r\nconnection: close\r\n\
             content-type: application/json\r\ncontent-length: {}\r\n\r\n{body}",
            body.len()
        )
        .expect("sent");
        let mut bytes = Vec::new();
        stream.read_to_end(&mut bytes).expect("answered");
        let cut = bytes
            .windows(4)
            .position(|w| w == b"\r\n\r\n")
            .expect("a head");
        let head = String::from_utf8_lossy(&bytes[..cut]).into_owned();
        let status = head[9..12].parse().expect("a status");
        HttpAnswer {
            status,
            head,
            body: bytes[cut + 4..].to_vec(),
        }
    }

    pub(crate) fn post(&self, path: &str, waypoint: &str) -> HttpAnswer {
        self.request("POST", path, &json!({"waypoint": waypoint}).to_string())
    }

    pub(crate) fn status(&self) -> Value {
        self.request("GET", "/status", "").json()
    }

    /// A visit with this sweep.
    pub(crate) fn visit(&self, sweep: ScriptedSweep) -> Value {
        self.scanner.script().sweep = sweep;
        let answer = self.post("/visit", "hall");
        assert_eq!(answer.status, 200, "{}", answer.json());
        answer.json()
    }

    pub(crate) fn stop(self) -> Duration {
        let start = Instant::now();
        self.command(ServiceCommand::Stop);
        let result = self.thread.join().expect("no panic");
        result.expect("the service ended without an error");
        start.elapsed()
    }
}

pub(crate) fn points(ply: &[u8]) -> Vec<Point3<f64>> {
    patrold_engine::formats::read_cloud(ply, Some("ply"))
        .expect("a PLY")
        .points
}
