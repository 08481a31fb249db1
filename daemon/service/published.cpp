#include "daemon/service/published.hpp"

namespace shaker::service {

namespace {

using State = const BenchState&;
using Value = PublishedValue;

template <class T>
Value of_base(State s, T BaseState::*member) {
    return s.base ? Value{(*s.base).*member} : Value{};
}
Value of_walker(State s, double WalkerState::*member) {
    return s.walker ? Value{(*s.walker).*member} : Value{};
}
Value of_tracking(State s, double TrackingState::*member) {
    return s.tracking ? Value{(*s.tracking).*member} : Value{};
}
Value of_result(State s, auto value) { return s.result ? Value{value(*s.result)} : Value{}; }
Value of_campaign(State s, auto value) { return s.campaign ? Value{value(*s.campaign)} : Value{}; }
Value count(int n) { return static_cast<std::uint64_t>(n); }

constexpr Published rows[] = {
    // the bench
    {nullptr, "SYSTem:CLOCk", nullptr, "s", "master time", [](State s) -> Value { return s.now_s; }},
    {"/session/since_s", nullptr, nullptr, "s", "time since the present state began",
     [](State s) -> Value { return s.now_s - s.since_s; }},
    {"/session/may_clear", nullptr, nullptr, "", "1 when a trip may be cleared",
     [](State s) -> Value { return s.may_clear; }},
    {"/session/identified", nullptr, nullptr, "", "1 when the response of the base is known",
     [](State s) -> Value { return s.response != nullptr; }},
    {nullptr, "OUTPut:PROTection:TRIPped", nullptr, "", "1 after an abort or a trip, until cleared",
     [](State s) -> Value { return s.state == run::RunState::tripped; }},
    {nullptr, nullptr, "trips_total", "", "number of trips of the drive",
     [](State s) -> Value { return s.trips; }},
    {nullptr, nullptr, "aborts_total", "", "number of aborts", [](State s) -> Value { return s.aborts; }},
    {"/jitter/worst_s", nullptr, nullptr, "s", "largest deviation of a block's period",
     [](State s) -> Value { return s.jitter.worst_s > 0 ? Value{s.jitter.worst_s} : Value{}; }},
    {"/tracking/median_s", nullptr, "tracking_median_seconds", "s",
     "half of the pictures are tracked in less time (slowest camera)",
     [](State s) { return of_tracking(s, &TrackingState::median_s); }},
    {"/tracking/slowest_s", nullptr, "tracking_slowest_seconds", "s",
     "99.9 % of the pictures are tracked in less time (slowest camera)",
     [](State s) { return of_tracking(s, &TrackingState::slowest_s); }},
    {"/tracking/core_share", "SYSTem:HEALth:TRACking", "tracking_core_ratio", "",
     "share of a processor that the tracking of all cameras takes",
     [](State s) { return of_tracking(s, &TrackingState::core_share); }},
    {nullptr, nullptr, "drive_samples_clamped_total", "", "samples of the drive cut at its limit",
     [](State s) -> Value { return s.lost.samples_clamped; }},
    {"/switches/enable_output", nullptr, "enable_output", "",
     "1 while the enable output of the amplifier is on",
     [](State s) -> Value { return s.enable_output ? Value{*s.enable_output} : Value{}; }},
    // the base
    {nullptr, nullptr, "drive_asked_frequency_hertz", "Hz", "requested frequency",
     [](State s) -> Value { return s.wanted.frequency; }},
    {nullptr, nullptr, "drive_asked_gamma_metres_per_second_squared", "m/s2", "requested gamma",
     [](State s) -> Value { return s.wanted.gamma; }},
    {"/drive/closed_loop", nullptr, nullptr, "", "1: measured harmonics correct the drive",
     [](State s) -> Value { return s.closed_loop; }},
    {"/drive/locked", "CONTrol:LOOP:LOCKed", "drive_locked", "",
     "1 while the base is within the tolerance of its target", [](State s) -> Value { return s.locked; }},
    {"/measured/gamma_mps2", nullptr, "base_gamma_metres_per_second_squared", "m/s2",
     "measured gamma of the newest period",
     [](State s) { return s.base ? Value{s.base->got.gamma} : Value{}; }},
    {"/measured/phi_rad", nullptr, nullptr, "rad", "measured phi of the newest period",
     [](State s) { return s.base ? Value{s.base->got.phi} : Value{}; }},
    {"/measured/rms_mps2", nullptr, "base_rms_metres_per_second_squared", "m/s2",
     "acceleration along the axis in the newest period, rms",
     [](State s) { return of_base(s, &BaseState::rms); }},
    {"/measured/residual_mps2", "FETCh:ACCeleration:RESidual", nullptr, "m/s2",
     "residual of the newest period after harmonics and mains, rms",
     [](State s) { return of_base(s, &BaseState::residual); }},
    {"/measured/volts_peak", nullptr, "drive_peak_volts", "V", "peak of the drive",
     [](State s) { return of_base(s, &BaseState::volts_peak); }},
    // the walker
    {"/walker/x_m", nullptr, "walker_position_metres", "m", "newest position of the walker",
     [](State s) { return of_walker(s, &WalkerState::x_m); }},
    {"/walker/left_m", nullptr, nullptr, "m", "position at the left end of the picture",
     [](State s) { return of_walker(s, &WalkerState::left_m); }},
    {"/walker/right_m", nullptr, nullptr, "m", "position at the right end of the picture",
     [](State s) { return of_walker(s, &WalkerState::right_m); }},
    {"/walker/edge_m", nullptr, nullptr, "m", "distance of the walker from the edge",
     [](State s) { return of_walker(s, &WalkerState::edge_m); }},
    {"/session/to_middle", nullptr, nullptr, "", "1 while the walker is being brought to the middle",
     [](State s) -> Value { return s.to_middle; }},
    // the newest measurement
    {nullptr, "FETCh:STEady", nullptr, "", "1 while a measurement is under way",
     [](State s) -> Value { return s.measuring; }},
    {nullptr, nullptr, "drift_velocity_metres_per_second", "m/s", "v_D of the newest measurement",
     [](State s) { return of_result(s, [](const auto& r) { return r.v_D.value; }); }},
    {nullptr, nullptr, "drift_velocity_standard_error_metres_per_second", "m/s", "its standard error",
     [](State s) { return of_result(s, [](const auto& r) { return r.v_D.sigma; }); }},
    {"/result/shortest_visible_stick", nullptr, nullptr, "", "shortest stick that can be seen, in periods",
     [](State s) { return of_result(s, [](const auto& r) { return r.shortest_visible_stick; }); }},
    {"/result/age_s", nullptr, nullptr, "s", "time since the newest measurement ended",
     [](State s) { return of_result(s, [&](const auto&) { return s.now_s - s.result_origin.to_s; }); }},
    {"/result/periods", nullptr, nullptr, "", "periods of a measurement",
     [](State s) { return count(s.plan.periods); }},
    {"/result/settle_periods", nullptr, nullptr, "", "periods of settled drive before it; 0: until steady",
     [](State s) { return count(s.plan.settle); }},
    // the campaign
    {"/campaign/active", "CAMPaign:ACTive", nullptr, "",
     "1 while a campaign has the bench or its table is written",
     [](State s) { return of_campaign(s, [](const auto& c) { return c.active; }); }},
    {"/campaign/paused", "CAMPaign:WAITing", nullptr, "", "1 while it is paused and waits for a person",
     [](State s) { return of_campaign(s, [](const auto& c) { return c.paused; }); }},
    {"/campaign/points", "CAMPaign:POINts", "campaign_points", "", "points of its plan",
     [](State s) { return of_campaign(s, [](const auto& c) { return std::uint64_t{c.points}; }); }},
    {"/campaign/ended", "CAMPaign:ENDed", "campaign_points_ended", "", "points that have ended",
     [](State s) { return of_campaign(s, [](const auto& c) { return std::uint64_t{c.ended}; }); }},
    {"/campaign/left_s", "CAMPaign:LEFT", "campaign_left_seconds", "s",
     "expected time left, as predicted and corrected by the points so far",
     [](State s) { return of_campaign(s, [](const auto& c) { return c.left_s; }); }},
    // recording
    {"/session/record_next", nullptr, nullptr, "", "1: the next run is recorded",
     [](State s) -> Value { return s.record; }},
    {nullptr, nullptr, "recording", "", "1 while a run is being recorded",
     [](State s) -> Value { return !s.recording.name.empty(); }},
    {"/session/finishing", "RECord:FINishing", "recording_finishing", "",
     "1 while the recording of the last run is being completed",
     [](State s) -> Value { return s.recording.finishing; }},
    {"/disk/backlog", nullptr, "writer_backlog_ratio", "", "filled share of the recorder's queue, 0 to 1",
     [](State s) -> Value { return s.recording.backlog; }},
    {nullptr, nullptr, "writer_pieces_lost_total", "",
     "items of the present recording lost because the queue was full",
     [](State s) -> Value { return s.recording.pieces_lost; }},
    {"/disk/free_bytes", nullptr, "disk_free_bytes", "bytes", "free space on the disk of the recordings",
     [](State s) -> Value { return s.recording.free_bytes; }},
    {"/disk/room_bytes", nullptr, "disk_room_bytes", "bytes",
     "free space without the part that must stay free",
     [](State s) -> Value { return s.recording.room_bytes; }},
};

}  // namespace

std::string Published::text() const { return *unit == 0 ? help : std::string{help} + ", " + unit; }

std::span<const Published> published_quantities() noexcept { return rows; }

}  // namespace shaker::service
