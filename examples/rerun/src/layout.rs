//! What the viewer shows where.

use rerun::blueprint::components::{LoopMode, PanelState, PlayState};
use rerun::blueprint::{
    Blueprint, BlueprintPanel, ContainerLike, Horizontal, SelectionPanel, Spatial3DView, TimePanel,
    TimeSeriesView, Vertical,
};

/// Simulated time.
pub const TIMELINE: &str = "sim_time";
/// All that has a place in space, the energies (J), and the forces (N).
pub const WORLD: &str = "world";
pub const ENERGIES: &str = "energy";
pub const FORCES: &str = "force";

/// Seconds of simulation shown in a second: a bounce takes a few hundredths.
const SPEED: f64 = 0.1;
/// Width of the scene beside that of the plots.
const SHARES: [f32; 2] = [2.0, 1.0];

/// The scene, and beside it the plots.
pub fn blueprint() -> Blueprint {
    let scene = Spatial3DView::new("Scene").with_origin(WORLD);
    let plot = |name: &str, origin: &str| -> ContainerLike {
        TimeSeriesView::new(name).with_origin(origin).into()
    };
    let plots = Vertical::new([plot("Energy (J)", ENERGIES), plot("Force (N)", FORCES)]);
    let root = Horizontal::new([scene.into(), plots.into()]).with_column_shares(SHARES);
    Blueprint::new(root)
        .with_blueprint_panel(BlueprintPanel::from_state(PanelState::Collapsed))
        .with_selection_panel(SelectionPanel::from_state(PanelState::Collapsed))
        .with_time_panel(time_panel())
}

/// Simulated time, slowly, over and over.
fn time_panel() -> TimePanel {
    TimePanel::new()
        .with_state(PanelState::Collapsed)
        .with_timeline(TIMELINE)
        .with_playback_speed(SPEED)
        .with_play_state(PlayState::Playing)
        .with_loop_mode(LoopMode::All)
}
