#include "daemon/campaign/campaign.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <exception>
#include <utility>

#include "drivers/errors.hpp"

namespace shaker::campaign {

namespace {

std::string why_of(const std::exception_ptr& failure) try {
    std::rethrow_exception(failure);
} catch (const std::exception& e) {
    return e.what();
}

}  // namespace

Campaign::Campaign(run::Runner& runner, Engine& engine, const CampaignSettings& settings, Listener listener)
    : runner_{runner},
      engine_{engine},
      settings_{settings},
      listener_{std::move(listener)},
      on_call_{runner, settings.beside} {}

bool Campaign::step(const acquisition::Streams& streams, acquisition::Channels& channels) {
    const bool any = on_call_.take(streams, channels);
    while (const auto measured = on_call_.measured()) engine_.take(*measured);
    try {
        carry_out(engine_.next(seen(channels)), channels);
    } catch (const std::exception& e) {
        engine_.refused(e.what());
    }
    on_call_.follow(settings_.run, channels);
    while (const auto run = on_call_.finished())
        if (run->failure) engine_.failed("a recording could not be completed: " + why_of(run->failure));
    count_time();
    for (const Event& event : engine_.events()) listener_(event, runner_.sequence().now_s());
    return any;
}

void Campaign::count_time() {
    const run::Sequence& sequence = runner_.sequence();
    const double passed_s = sequence.now_s() - std::exchange(timed_to_s_, sequence.now_s());
    const bool drives = run::driving(sequence.state());
    if (engine_.paused() && !drives) return;
    const bool steady = sequence.state() == run::RunState::run;
    double& use = !steady                ? time_.checking
                  : engine_.returning()  ? time_.returning
                  : sequence.measuring() ? time_.measuring
                                         : time_.settling;
    use += passed_s;
}

void Campaign::obey(const std::string& word, acquisition::Channels& channels) {
    static constexpr std::array<std::pair<std::string_view, Word>, 5> words{{{"pause", Word::pause},
                                                                             {"resume", Word::resume},
                                                                             {"skip", Word::skip},
                                                                             {"repeat", Word::repeat},
                                                                             {"stop", Word::stop}}};
    const auto known = std::ranges::find(words, word, &std::pair<std::string_view, Word>::first);
    if (known != words.end()) return engine_.obey(known->second);
    if (word == "abort") {
        ++channels.aborts;
    } else if (word == "clear") {
        on_call_.clear(runner_.sequence().stops().size(), channels.aborts, channels);
    } else {
        throw InputError{
            fmt::format("\"{}\": expected pause, resume, skip, repeat, stop, abort or clear", word)};
    }
}

Seen Campaign::seen(const acquisition::Channels& channels) const {
    const run::Sequence& sequence = runner_.sequence();
    run::RunState state = on_call_.state();
    if (state == run::RunState::run && !sequence.may_set()) state = run::RunState::ramp;
    Seen s{.now_s = sequence.now_s(),
           .state = state,
           .trip = sequence.trip() ? text(*sequence.trip()) : std::string{},
           .may_start = state == run::RunState::idle && !channels.stopped,
           .identified = !settings_.run.identify || sequence.controller().identified().has_value(),
           .holding = sequence.holding(),
           .pending = on_call_.pending(),
           .recorded_s = sequence.now_s() - recording_from_s_,
           .free_bytes = runner_.recordings().free_bytes(),
           .x_m = sequence.walker().x_m().value_or(unknown)};
    const std::array<double, 2> ways_mm = sequence.walker().mean_ways_mm();
    const Point* point = engine_.point();
    if (!sequence.walker().watches() || point == nullptr || !std::isfinite(ways_mm[0])) return s;
    const double inside_mm =
        on_call_.limits().edge_mm + settings_.edge_margin_mm + on_call_.oscillation_mm(point->asked.drive);
    for (std::size_t i = 0; i < 2; ++i) s.way.at(i) = 1e-3 * (ways_mm.at(i) - inside_mm);
    return s;
}

void Campaign::carry_out(const Action& action, acquisition::Channels& channels) {
    if (const auto* start = std::get_if<Start>(&action)) {
        run::RunOptions run = settings_.run;
        run.drive = start->drive;
        run.periods = std::max(start->task.periods, 2);
        const auto file = settings_.folder / fmt::format("r{:03}.nxs", ++settings_.recordings);
        on_call_.begin(run, start->task, file, engine_.walk(start->drive), channels);
        recording_from_s_ = runner_.sequence().now_s();
    } else if (const auto* change = std::get_if<Change>(&action)) {
        on_call_.set(change->drive, change->task, channels);
    } else if (std::holds_alternative<Stop>(action)) {
        runner_.sequence().end(channels);
    }
}

}  // namespace shaker::campaign
