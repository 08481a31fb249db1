#pragma once
// A bench without devices for the engine of campaigns: a walker that drifts as the exact law says, settles
// and is measured in no time.
#include <algorithm>
#include <cmath>
#include <deque>
#include <functional>
#include <memory>
#include <utility>
#include <vector>

#include "daemon/campaign/engine.hpp"

namespace shaker::campaign {

inline constexpr double dt_s = 0.05;  // a period
inline constexpr int runs_on = 3;  // periods from an order until it is in force: the walker goes on as before
inline constexpr double margin = 2e-3;  // m, from the end of the way to the limit at the edge

/// Plays the bench in steps of one period.
class EngineBench {
public:
    EngineBench(double length_m, double x_m, double mu = 0.113)
        : length_m_{length_m}, x_m_{x_m}, walks_{mu} {}

    /// Leads the engine to its end, or until `limit_s`.
    void play(Engine& engine, double limit_s = 3600) {
        for (; !engine.done() && now_s_ < limit_s; now_s_ += dt_s) {
            for (const auto& [when, word] : words_)
                if (now_s_ >= when && now_s_ < when + dt_s) engine.obey(word);
            step(engine);
        }
    }
    /// One period.
    void step(Engine& engine) {
        if (trip_at_s_ <= now_s_) trip();
        if (clear_at_s_ <= now_s_ && state_ == run::RunState::tripped) {
            state_ = run::RunState::idle;
            clear_at_s_ = INFINITY;
        }
        while (!reducing_.empty() && reducing_.front().first <= now_s_) {
            engine.take(reducing_.front().second);
            reducing_.pop_front();
        }
        if (passing() && now_s_ >= passes_s_) state_ = next_state_;
        obey(engine.next(seen()), engine);
        move(engine);
        for (Event& e : engine.events()) events.push_back(std::move(e));
    }
    void trip_at(double s, double clear_s) { trip_at_s_ = s, clear_at_s_ = clear_s; }
    [[nodiscard]] run::RunState state() const { return state_; }
    /// Measurements that the bench has finished.
    [[nodiscard]] int measurements() const { return number_; }
    void say(double s, Word word) { words_.emplace_back(s, word); }

    std::vector<Event> events;
    double now_s_ = 0;
    int edges = 0;  // times that the walker was beyond the limit at the edge
    int starts = 0;
    bool fails = false;  // no measurement can be reduced
    /// Of a measurement, by the true v_D and the number of periods.
    std::function<calibration::Estimate(double, int)> result = [](double v_D, int periods) {
        return calibration::Estimate{v_D, 1e-4 / std::sqrt(periods)};
    };
    double free_bytes = INFINITY;
    double start_s = 0, stop_s = 0;  // from an order at rest to state run; of a soft stop
    double reduction_s = 0;          // from the end of a measurement to its result
    double recording_s = INFINITY;   // then the recording is full, which ends the drive

private:
    [[nodiscard]] bool passing() const {
        return state_ == run::RunState::loop_check || state_ == run::RunState::ramp_down;
    }
    void pass(run::RunState by, double for_s, run::RunState to) {
        state_ = for_s > 0 ? by : to;
        next_state_ = to;
        passes_s_ = now_s_ + for_s;
    }
    void come_down(Engine& engine) {
        if (measured_s_ > 7 * dt_s) give(engine);
        measured_s_ = 0;
        pass(run::RunState::ramp_down, stop_s, run::RunState::idle);
    }
    [[nodiscard]] Seen seen() const {
        return {.now_s = now_s_,
                .state = state_,
                .may_start = state_ == run::RunState::idle,
                .holding = state_ == run::RunState::run && left_ == 0,
                .pending = !reducing_.empty(),
                .recorded_s = now_s_ - started_s_,
                .free_bytes = free_bytes,
                .x_m = x_m_,
                .way = {x_m_ + length_m_ / 2, length_m_ / 2 - x_m_}};
    }
    void trip() {
        trip_at_s_ = INFINITY;
        state_ = run::RunState::tripped;
        left_ = 0, measured_s_ = 0;
    }
    void obey(const Action& action, Engine& engine) {
        if (const auto* start = std::get_if<Start>(&action)) {
            ++starts;
            started_s_ = now_s_;
            aim(start->drive, start->task);
        } else if (const auto* change = std::get_if<Change>(&action)) {
            if (measured_s_ > 7 * dt_s) give(engine);
            aim(change->drive, change->task);
        } else if (std::holds_alternative<Stop>(action)) {
            come_down(engine);
        }
    }
    [[nodiscard]] const Drive& played() const { return now_s_ < runs_on_s_ - 1e-9 ? before_ : drive_; }
    void aim(const Drive& drive, const run::Task& task) {
        if (state_ == run::RunState::run)
            before_ = played(), runs_on_s_ = now_s_ + runs_on * dt_s;
        else
            pass(run::RunState::loop_check, start_s, run::RunState::run);
        drive_ = drive;
        task_ = task;
        left_ = task.plan.periods == 0 ? 0 : task.plan.measurements;
        settled_s_ = std::max(now_s_, passes_s_) + dt_s * (1 + std::max(25, walks_.at(drive).settling));
        measured_s_ = 0;
    }
    void move(Engine& engine) {
        if (state_ != run::RunState::run) return;
        if (now_s_ - started_s_ > recording_s) return come_down(engine);
        x_m_ += walks_.at(played()).v_D * dt_s;
        if (std::abs(x_m_) > length_m_ / 2 + margin) ++edges;
        if (left_ == 0 || now_s_ < settled_s_) return;
        measured_s_ += dt_s;
        if (measured_s_ < (task_.plan.periods + 2) * dt_s - 1e-9) return;
        give(engine);
        --left_;
        measured_s_ = 0;
    }
    void give(Engine& engine) {
        on_call::Measured m;
        const int whole = std::min(task_.plan.periods, static_cast<int>(measured_s_ / dt_s + 1e-9) - 2);
        m.measurement.number = ++number_;
        m.measurement.asked = drive_;
        m.measurement.part = {now_s_ - whole * dt_s, now_s_};
        m.recording = "r001.nxs";
        if (fails) {
            m.not_reduced = "no walker";
        } else {
            auto r = std::make_shared<reduction::Reduction>();
            r->v_D = result(walks_.at(drive_).v_D, whole);
            m.reduction = r;
        }
        if (reduction_s > 0)
            reducing_.emplace_back(now_s_ + reduction_s, m);
        else
            engine.take(m);
    }

    double length_m_, x_m_;
    WalkPredictor walks_;
    run::RunState state_ = run::RunState::idle, next_state_ = run::RunState::idle;
    double passes_s_ = 0;                                          // to next_state_
    std::deque<std::pair<double, on_call::Measured>> reducing_{};  // with the times of their results
    Drive drive_, before_;
    double runs_on_s_ = 0;  // before_ is in force until then
    run::Task task_;
    int left_ = 0, number_ = 0;
    double settled_s_ = 0, measured_s_ = 0, started_s_ = 0;
    double trip_at_s_ = INFINITY, clear_at_s_ = INFINITY;
    std::vector<std::pair<double, Word>> words_;
};

inline Point point(int id, double gamma_g, double phi, int periods = 40) {
    Point p{.id = id, .series = "s", .asked = {}, .repeat = 1, .partner = 0};
    p.asked.drive.gamma = gamma_g * paper_g;
    p.asked.drive.phi = phi;
    p.asked.plan.periods = periods;
    return p;
}

template <class T>
std::vector<T> all(const std::vector<Event>& events) {
    std::vector<T> found;
    for (const Event& e : events)
        if (const auto* t = std::get_if<T>(&e)) found.push_back(*t);
    return found;
}

}  // namespace shaker::campaign
