#include "calibration/clocks/timebase.hpp"

#include <cmath>

namespace shaker::calibration {

namespace {

template <class Clock>
ClockFit fit_of(const ClockTracker<Clock>& clock, std::size_t stamps, std::size_t jumps) {
    return {clock.ppm(), clock.ppm_sigma(), clock.map() ? clock.residual() : Seconds{NAN}, stamps, jumps};
}

}  // namespace

Timebase::Timebase(const TimebaseDevices& devices)
    : devices_{devices}, dac_{devices.dac_rate_hz}, accelerometer_{devices.accelerometer_rate_hz} {
    for (const View& view : devices.cameras)
        cameras_.push_back({.clock = ExposureClock{view, devices.dac_rate_hz}});
}

void Timebase::add(const PlayTime& played) noexcept {
    ++plays_;
    if (played.lost > 0) {
        ++underruns_;
        dac_.restart();
    } else {
        dac_.add(played.tick, played.heard);
    }
    for (Timebase& recording : recording_) recording.add(played);
}

void Timebase::add(const AccelBlock& block) noexcept {
    ++blocks_;
    accelerometer_.add({block.first.n + block.size - 1}, block.arrived);
    for (Timebase& recording : recording_) recording.add(block);
}

void Timebase::add(std::size_t camera, const FrameStamp& frame, FrameTime time) {
    ++cameras_.at(camera).stamps;
    if (time == FrameTime::frame)
        cameras_[camera].clock.count(frame);
    else
        cameras_[camera].clock.add(frame);
    for (Timebase& recording : recording_)
        recording.add(camera, frame, time == FrameTime::all_stamps ? time : FrameTime::frame);
}

void Timebase::begin_recording() { recording_.assign(1, Timebase{devices_}); }

Timebase Timebase::end_recording() {
    Timebase recorded = this->recorded();
    recording_.clear();
    recorded.recording_.clear();
    return recorded;
}

MasterTime Timebase::at(AccelTick tick) const noexcept {
    if (plays_ == 0)
        return master_time(devices_.first_sample_s + counted_s(tick, devices_.accelerometer_rate_hz));
    const auto dac = dac_.map();
    const auto accelerometer = accelerometer_.map();
    if (!dac || !accelerometer) return master_time(NAN);
    const AccelTick at = devices_.dac_clock ? accelerometer->middle() : tick;
    const TickInstant<DacClock> k = dac->at(accelerometer->at(at));
    const double at_s = (static_cast<double>(k.tick.n) + k.fraction) / devices_.dac_rate_hz;
    return master_time(at_s + counted_s(AccelTick{tick.n - at.n}, devices_.accelerometer_rate_hz));
}

std::optional<HostTime> Timebase::heard(DacTick tick) const noexcept {
    const auto dac = dac_.map();
    return dac ? std::optional{dac->at(tick)} : std::nullopt;
}

MasterTime Timebase::mid_exposure(std::size_t camera, std::size_t number, const FrameStamp& frame) {
    const auto dac = dac_.map();
    return dac ? cameras_.at(camera).clock.mid_exposure(number, frame, *dac) : master_time(NAN);
}

void Timebase::settle() {
    for (FrameClock& camera : cameras_) camera.clock.forget_lag();
}

ClockFit Timebase::dac() const noexcept { return fit_of(dac_, plays_, underruns_); }

ClockFit Timebase::accelerometer() const noexcept { return fit_of(accelerometer_, blocks_, 0); }

ClockFit Timebase::camera(std::size_t camera) const {
    const FrameClock& c = cameras_.at(camera);
    ClockFit fit = fit_of(c.clock.exposures(), c.stamps, c.clock.jumps());
    if (!(devices_.cameras[camera].frame_rate_hz > 0)) fit.ppm = fit.ppm_sigma = NAN;
    return fit;
}

std::optional<ClockFit> Timebase::camera_stamps(std::size_t camera) const {
    const FrameClock& c = cameras_.at(camera);
    if (!c.clock.stamps().map()) return std::nullopt;
    return fit_of(c.clock.stamps(), c.stamps, c.clock.jumps());
}

}  // namespace shaker::calibration
