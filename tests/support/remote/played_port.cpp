#include "tests/support/remote/played_port.hpp"

#include <array>
#include <cmath>
#include <memory>

#include "drivers/errors.hpp"

namespace shaker::test {

namespace {

std::shared_ptr<const reduction::Reduction> some_result() {
    auto r = std::make_shared<reduction::Reduction>();
    r->v_D = {0.0145, 3e-5};
    r->D = {0.0145 / 20, 1.5e-6};
    r->efficiency = {0.47, 0.001};
    r->frequency = {20, 0};
    r->gamma = {9.8, 0.001};
    r->phi = {0.6, 1e-4};
    for (int i = 0; i < 64; ++i) {
        const double p = i / 64.0;
        r->cycle.phase.push_back(p);
        r->cycle.x_m.push_back(1e-3 * p);
        r->cycle.x_sd_m.push_back(1e-6);
        r->cycle.v_mps.push_back(std::sin(two_pi * p));
        r->cycle.v_sd_mps.push_back(1e-3);
        r->cycle.v_base_mps.push_back(std::cos(two_pi * p));
    }
    return r;
}

service::PictureState grey_picture() {
    auto frame = std::make_shared<Frame>();
    frame->width = 64;
    frame->height = 16;
    frame->pixels.assign(std::size_t{64} * 16, std::byte{100});
    return {.camera = "top", .t_s = 12.5, .frame = frame, .fixes = {}, .targets = {}};
}

}  // namespace

PlayedPort::PlayedPort() {
    state_.state = run::RunState::idle;
    state_.facts = std::make_shared<const service::BenchFacts>(
        service::BenchFacts{.rig = "played",
                            .dac = {},
                            .accelerometer = {},
                            .views = {{.camera = "top", .targets = {{.name = "walker"}}}},
                            .soft_start_periods = 10,
                            .mu = {}});
    state_.devices = {
        {"dac", "samples", {}}, {"accelerometer", "samples", {}}, {"camera \"top\"", "frames", {}}};
    state_.plan.periods = 40;
    state_.plans = {"fig3", "mu"};
    state_.real_time = {{"memory", ""}, {"output", "output: cannot set real-time priority 70"}};
    state_.contact = Contact::open;
    state_.enable_output = true;
    state_.limits.acceleration = {40, 50};
    bench_port.stop_by(
        [this] {
            const auto number = static_cast<std::uint64_t>(++aborts);
            if (!hung) obeyed_ = number;
            return number;
        },
        [this] { return obeyed_.load(); });
    bench_port.publish(std::make_shared<service::BenchState>(state_));
}

std::vector<service::OrderWhat> PlayedPort::ordered() const {
    const std::scoped_lock lock{mutex_};
    return ordered_;
}

std::string PlayedPort::obey(const service::OrderWhat& what) {
    if (const auto* set = std::get_if<service::SetDrive>(&what)) {
        if (set->drive.gamma > 100) return "acceleration 120 m/s^2: at most 50 is allowed";
        state_.wanted = set->drive;
    } else if (std::holds_alternative<service::Begin>(what)) {
        if (state_.state != run::RunState::idle)
            return "a run cannot start in state " + std::string{name(state_.state)};
        const auto& begin = std::get<service::Begin>(what);
        if (begin.drive && begin.drive->gamma > 100) return "acceleration 120 m/s^2: at most 50 is allowed";
        state_.wanted = begin.drive.value_or(state_.wanted);
        state_.state = run::RunState::run;
        state_.measuring = true;
        state_.plan = begin.plan;
        state_.plan.measurements = 0;
        state_.result = some_result();
        state_.result_origin = {state_.result_origin.number + 1, state_.wanted, state_.now_s, state_.now_s};
    } else if (std::holds_alternative<service::End>(what)) {
        state_.state = run::RunState::idle;
        state_.measuring = false;
    } else if (std::holds_alternative<service::ClearTrip>(what)) {
        clears_in_ = clears_after;
        if (clears_in_ == 0) end_trip();
    } else if (const auto* plan = std::get_if<service::MeasurePlan>(&what)) {
        if (plan->text.empty() && plan->name != "fig3")
            return "plan \"" + plan->name + "\": there is no such plan";
        state_.campaign = service::CampaignState{
            .name = plan->name, .folder = plan->name + "-x", .doing = "ended", .points = 12, .ended = 12};
    } else if (const auto* check = std::get_if<service::CheckPlan>(&what)) {
        state_.plan_check = service::PlanCheckState{.name = check->name,
                                                    .points = 12,
                                                    .fit = check->name == "mu" ? 12U : 11U,
                                                    .summary = "12 points",
                                                    .misfits = {}};
        if (check->name != "mu") state_.plan_check->misfits = {"point 3 does not fit: its way is too long"};
    } else if (const auto* loop = std::get_if<service::CloseLoop>(&what)) {
        state_.closed_loop = loop->on;
    } else if (const auto* give = std::get_if<service::GiveMu>(&what)) {
        state_.mu = give->mu;
    } else if (const auto* remark = std::get_if<service::Remark>(&what)) {
        bench_port.log(state_.now_s, "remark", remark->text);
    } else if (const auto* record = std::get_if<service::Record>(&what)) {
        state_.record = record->on;
        state_.record_name = record->on ? record->name : std::string{};
        state_.pictures = record->pictures;
    } else if (const auto* lower = std::get_if<service::LowerLimit>(&what))
        try {
            safety::lower(state_.limits, lower->key, lower->value);
        } catch (const InputError& e) {
            return e.what();
        }
    return {};
}

void PlayedPort::end_trip() {
    clears_in_ = -1;
    state_.state = run::RunState::idle;
    state_.trip.reset();
    state_.trip_pictures.clear();
}

void PlayedPort::turn() {
    bool changed = false;
    if (clears_in_ > 0 && --clears_in_ == 0) end_trip();
    if (!hung && aborts > 0 && state_.aborts != static_cast<std::uint64_t>(aborts)) {
        state_.aborts = static_cast<std::uint64_t>(aborts);
        state_.state = run::RunState::tripped;
        state_.trip = safety::Trip{.cause = safety::Cause::operator_stop, .stop = safety::StopKind::hard};
        state_.may_clear = true;
        state_.trip_pictures = {grey_picture()};
        ++state_.trips;
        changed = true;
    }
    while (!deaf) {
        auto order = bench_port.next();
        if (!order) break;
        const std::string refused = obey(order->what);
        {
            const std::scoped_lock lock{mutex_};
            ordered_.push_back(order->what);
        }
        ++state_.answered;
        bench_port.publish(std::make_shared<service::BenchState>(state_));
        if (order->answer) order->answer(refused);
    }
    if (state_.waveform.asked.size() != wave) {
        state_.waveform.period_s = 0.05;
        state_.waveform.asked.assign(wave, 1.0F);
        state_.waveform.measured.assign(wave, 1.0F);
    }
    if (mu_refused) state_.fitted_mu = {.value = 0.083, .error = 1e-5, .refused = true};
    state_.now_s += 1e-3;
    if (state_.state == run::RunState::run) state_.measured_from_s = state_.now_s;
    const float now = static_cast<float>(state_.now_s);
    bench_port.feed().acceleration.add(state_.now_s, std::array{std::sin(now), std::cos(now)});
    if (changed || ++turns_ % shown_each == 0)
        bench_port.publish(std::make_shared<service::BenchState>(state_));
}

}  // namespace shaker::test
