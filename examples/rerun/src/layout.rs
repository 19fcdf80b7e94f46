//! Layout of the viewer.

use rerun::blueprint::components::{LoopMode, PanelState, PlayState};
use rerun::blueprint::{
    Blueprint, BlueprintPanel, ContainerLike, Horizontal, SelectionPanel, Spatial3DView, TimePanel,
    TimeSeriesView, Vertical,
};

/// Timeline of simulated time.
pub const TIMELINE: &str = "sim_time";
/// Paths of the scene, of the energies (J), and of the forces (N).
pub const WORLD: &str = "world";
pub const ENERGIES: &str = "energy";
pub const FORCES: &str = "force";

/// Seconds of simulation shown per second, because a bounce takes a few hundredths of a second.
const SPEED: f64 = 0.1;
/// Relative widths of the scene and of the plots.
const SHARES: [f32; 2] = [2.0, 1.0];

/// Returns the layout: the scene, and the plots beside it.
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

/// Returns a time panel that plays simulated time slowly in a loop.
fn time_panel() -> TimePanel {
    TimePanel::new()
        .with_state(PanelState::Collapsed)
        .with_timeline(TIMELINE)
        .with_playback_speed(SPEED)
        .with_play_state(PlayState::Playing)
        .with_loop_mode(LoopMode::All)
}
