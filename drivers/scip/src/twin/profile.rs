//! Which sensor the twin is: the lines by which it tells who it is, and what its firmware can do.

/// Identity and abilities of one model and firmware (protocol sections 1, 6, 9 and 12).
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Profile {
    /// `MODL` of `PP` and `II`.
    pub model: &'static str,
    /// `PROD` of `VV`.
    pub product: &'static str,
    /// `FIRM` of `VV`.
    pub firmware: &'static str,
    /// `SERI` of `VV`.
    pub serial: String,
    /// `FIRM`, `PROT` and `STAT` lines of the SCIP1.1 `V` reply; `None` for a sensor that wakes in SCIP2.0 and knows no other.
    pub scip1: Option<Scip1Lines>,
    /// Least distance, mm (`DMIN`).
    pub min_range_mm: u32,
    /// Greatest distance, mm (`DMAX`).
    pub max_range_mm: u32,
    /// Steps of a full revolution (`ARES`).
    pub steps_per_revolution: u32,
    /// First measuring step (`AMIN`).
    pub first_step: u32,
    /// Last measuring step (`AMAX`).
    pub last_step: u32,
    /// Step straight ahead (`AFRT`).
    pub front_step: u32,
    /// Nominal speed, revolutions per minute (`SCAN`).
    pub speed_rpm: u32,
    /// `SBPS` of a sensor without a serial line; `None` if it has one and tells its bit rate.
    pub usb_only_text: Option<&'static str>,
    /// Whether the firmware knows `HS` (from 3.2.00 on); an older one answers 0C.
    pub high_sensitivity: bool,
    /// Whether the firmware knows `DB` (from 3.3.00 on, not all units); another answers 0E.
    pub rehearsals: bool,
}

/// What the SCIP1.1 `V` reply says differently from `VV`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Scip1Lines {
    /// The `FIRM:` line.
    pub firmware: &'static str,
    /// The `PROT:` line.
    pub protocol: &'static str,
    /// The `STAT:` line.
    pub status: &'static str,
}

/// `VEND` of every model.
pub(super) const VENDOR: &str = "Hokuyo Automatic Co.,Ltd.";

impl Profile {
    /// URG-04LX H0706400 with firmware 3.1.04: USB and RS-232C, wakes in SCIP1.1 (section 12).
    pub fn urg_04lx() -> Self {
        Self {
            model: "URG-04LX(Hokuyo Automatic Co.,Ltd.)",
            product: "SOKUIKI Sensor URG-04LX",
            firmware: "3.1.04(02/Aug./2007)",
            serial: "H0706400".to_owned(),
            scip1: Some(Scip1Lines {
                firmware: "FIRM:3.1.04,07/08/02(20-4095[mm],240[deg],44-725[step],600[rpm])",
                protocol: "PROT:00003,(SCIP 1.0)",
                status: "STAT:FW Normal[FinalDist with shadow  ]",
            }),
            min_range_mm: 20,
            max_range_mm: 5600,
            steps_per_revolution: 1024,
            first_step: 44,
            last_step: 725,
            front_step: 384,
            speed_rpm: 600,
            usb_only_text: None,
            high_sensitivity: false,
            rehearsals: false,
        }
    }

    /// URG-04LX-UG01 H1510998 with firmware 3.4.03: USB only, wakes in SCIP2.0, knows `HS` and `DB` (sections 1 and 12).
    /// Its `SBPS` text is the one other USB-only models send.
    pub fn urg_04lx_ug01() -> Self {
        Self {
            model: "URG-04LX-UG01(Simple-URG)(Hokuyo Automatic Co.,Ltd.)",
            product: "SOKUIKI Sensor URG-04LX-UG01(Simple-URG)",
            firmware: "3.4.03(17/Dec./2012)",
            serial: "H1510998".to_owned(),
            scip1: None,
            usb_only_text: Some("USB Full Speed"),
            high_sensitivity: true,
            rehearsals: true,
            ..Self::urg_04lx()
        }
    }
}

impl Default for Profile {
    fn default() -> Self {
        Self::urg_04lx()
    }
}
