//! Small signs, drawn rather than taken from a font.

use super::canvas::{Canvas, Paint};
use super::frame::{NodeStatus, Verdict};
use super::geometry::Spot;
use super::path::Path;
use super::theme::{self, Color};

/// A sign that has the same meaning as a color.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Icon {
    /// ✓
    Check,
    /// ✗
    Cross,
    /// A triangle that points right, as on a play button.
    Play,
    /// A short dash.
    Dash,
    /// A question mark's place: two dots.
    Open,
    /// A flash.
    Bolt,
    /// An exclamation mark.
    Alert,
}

impl Icon {
    /// Draws the icon in a square of `size` pixels around `center`.
    pub fn draw(self, canvas: &mut Canvas, center: Spot, size: f64, color: Color) {
        let at = |x: f64, y: f64| (center.0 + x * size, center.1 + y * size);
        let line = Paint::stroke(color, size * 0.17);
        let through = |spots: &[(f64, f64)]| Path::through(spots.iter().map(|&(x, y)| at(x, y)));
        match self {
            Self::Check => canvas.path(&through(&[(-0.34, 0.04), (-0.1, 0.28), (0.36, -0.26)]), line),
            Self::Cross => {
                canvas.path(&through(&[(-0.27, -0.27), (0.27, 0.27)]), line);
                canvas.path(&through(&[(-0.27, 0.27), (0.27, -0.27)]), line);
            }
            Self::Play => {
                let triangle = through(&[(-0.22, -0.3), (0.32, 0.0), (-0.22, 0.3)]).close();
                canvas.path(&triangle, Paint::fill(color).outlined(color, size * 0.1));
            }
            Self::Dash => canvas.path(&through(&[(-0.26, 0.0), (0.26, 0.0)]), line),
            Self::Open => {
                let dots = Path::dots([at(-0.3, 0.0), at(0.0, 0.0), at(0.3, 0.0)]);
                canvas.path(&dots, Paint::stroke(color, size * 0.2));
            }
            Self::Alert => {
                canvas.path(&through(&[(0.0, -0.34), (0.0, 0.08)]), line);
                canvas.path(&Path::dots([at(0.0, 0.36)]), Paint::stroke(color, size * 0.2));
            }
            Self::Bolt => {
                let flash = [(0.12, -0.5), (-0.3, 0.1), (-0.02, 0.1), (-0.12, 0.5), (0.3, -0.12), (0.02, -0.12)];
                canvas.path(&through(&flash).close(), Paint::fill(color));
            }
        }
    }
}

/// How the status of a node is shown.
#[derive(Clone, Copy, Debug)]
pub struct Look {
    /// The ground.
    pub ground: Color,
    /// Outline and sign.
    pub front: Color,
    /// The sign.
    pub icon: Icon,
    /// The status in words.
    pub words: &'static str,
}

impl Look {
    /// How a node of a tree looks.
    pub fn of_status(status: NodeStatus) -> Self {
        let (ground, front, icon, words) = match status {
            NodeStatus::Success => (theme::GOOD_LIGHT, theme::GOOD, Icon::Check, "success"),
            NodeStatus::Failure => (theme::BAD_LIGHT, theme::BAD, Icon::Cross, "failure"),
            NodeStatus::Running => (theme::BUSY_LIGHT, theme::BUSY, Icon::Play, "running"),
            NodeStatus::NotTicked => (theme::IDLE_LIGHT, theme::IDLE, Icon::Dash, "not ticked"),
        };
        Self { ground, front, icon, words }
    }

    /// How a verdict looks.
    pub fn of_verdict(verdict: Verdict) -> Self {
        let (front, icon, words) = match verdict {
            Verdict::HoldsSoFar => (theme::GOOD, Icon::Open, "undecided"),
            Verdict::Satisfied => (theme::GOOD, Icon::Check, "satisfied"),
            Verdict::Violated => (theme::BAD, Icon::Cross, "violated"),
            Verdict::Inconclusive => (theme::MUTED, Icon::Dash, "inconclusive"),
        };
        Self { ground: front, front: theme::PAPER, icon, words }
    }
}
