#include "tests/mock/mock_commands.hpp"

#include <spdlog/fmt/fmt.h>

#include <cmath>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>

#include "drivers/errors.hpp"
#include "drivers/quantity.hpp"

namespace shaker::mock {

namespace {

using Json = nlohmann::ordered_json;

// The remaining words of a line.
class Words {
public:
    explicit Words(const std::string& line) : line_{line}, in_{line} {}

    std::string next(const char* expected) {
        std::string word;
        if (!(in_ >> word)) fail("expected " + std::string{expected} + " at its end");
        return word;
    }
    double number(const char* name, Range allowed) {
        const std::string word = next(name);
        std::size_t used = 0;
        double x = NAN;
        try {
            x = std::stod(word, &used);
        } catch (const std::logic_error&) {
            used = 0;
        }
        if (used != word.size() || !(x >= allowed.min && x <= allowed.max))
            fail(std::string{name} + " = \"" + word + "\" is not allowed: must be " + to_text(allowed));
        return x;
    }
    std::uint64_t count(const char* name) { return static_cast<std::uint64_t>(number(name, {1, 1e9})); }
    std::int64_t nanoseconds(const char* name, Range allowed_s) {
        return std::llround(1e9 * number(name, allowed_s));
    }
    void finish() {
        std::string word;
        if (in_ >> word) fail("\"" + word + "\" is one word too many");
    }
    [[noreturn]] void fail(const std::string& why) const { throw InputError{"\"" + line_ + "\": " + why}; }

private:
    std::string line_;
    std::istringstream in_;
};

constexpr Range duration_s{1e-3, 3600}, clock_s{-3600, 3600}, experiment_s{0, 1e6};

template <class Device>
struct Action {
    const char* arguments;
    const char* meaning;
    std::function<void(Device&, Words&, Json&)> act;
};
template <class Device>
using Actions = std::map<std::string, Action<Device>>;

const Actions<Converter>& dac_actions() {
    static const Actions<Converter> actions{
        {"underrun",
         {"", "the stream stops as after an underrun",
          [](Converter& d, Words&, Json&) { d.cause_underrun(); }}},
        {"stall",
         {"SECONDS", "playback halts",
          [](Converter& d, Words& w, Json&) { d.stall(Seconds{w.number("SECONDS", duration_s)}); }}},
        {"unplug", {"", "the device disappears", [](Converter& d, Words&, Json&) { d.unplug(); }}},
        {"plug", {"", "the device returns", [](Converter& d, Words&, Json&) { d.plug(); }}}};
    return actions;
}

const Actions<Iiod>& accelerometer_actions() {
    static const Actions<Iiod> actions{
        {"silence",
         {"SECONDS", "nothing is sent, then all of it at once",
          [](Iiod& a, Words& w, Json&) { a.silence(w.number("SECONDS", duration_s)); }}},
        {"freeze",
         {"SECONDS", "the last sample is repeated",
          [](Iiod& a, Words& w, Json&) { a.freeze(w.number("SECONDS", duration_s)); }}},
        {"drop",
         {"SAMPLES", "the next samples are lost",
          [](Iiod& a, Words& w, Json&) { a.drop(w.count("SAMPLES")); }}},
        {"disconnect",
         {"", "clients are disconnected and may reconnect", [](Iiod& a, Words&, Json&) { a.disconnect(); }}},
        {"error",
         {"ERRNO", "every open buffer ends with this error, e.g. -110",
          [](Iiod& a, Words& w, Json&) {
              a.error(static_cast<int>(w.number("ERRNO", {-133, -1})));
          }}},
        {"shift",
         {"SECONDS", "the clock of the stamps jumps",
          [](Iiod& a, Words& w, Json&) { a.shift_stamps(w.nanoseconds("SECONDS", clock_s)); }}},
        {"jitter",
         {"SECONDS", "stamps are late in bursts, by up to this; 0 ends it", [](Iiod& a, Words& w, Json&) {
              a.jitter_stamps(w.nanoseconds("SECONDS", {0, 1}));
          }}}};
    return actions;
}

const Actions<GigeCamera>& camera_actions() {
    static const Actions<GigeCamera> actions{
        {"lose",
         {"SHARE", "each packet is lost with this probability; 0 ends it",
          [](GigeCamera& c, Words& w, Json&) {
              c.lose(w.number("SHARE", {0, 1}));
          }}},
        {"stall",
         {"SECONDS", "nothing is sent, then all of it at once",
          [](GigeCamera& c, Words& w, Json&) { c.stall(w.number("SECONDS", duration_s)); }}},
        {"drop",
         {"FRAMES", "the next exposures are not sent",
          [](GigeCamera& c, Words& w, Json&) { c.drop(w.count("FRAMES")); }}},
        {"shift",
         {"SECONDS", "the clock of the stamps jumps",
          [](GigeCamera& c, Words& w, Json&) { c.shift_stamps(w.nanoseconds("SECONDS", clock_s)); }}},
        {"unplug", {"", "the cable is pulled", [](GigeCamera& c, Words&, Json&) { c.unplug(); }}},
        {"plug", {"", "it returns after a restart", [](GigeCamera& c, Words&, Json&) { c.plug(); }}}};
    return actions;
}

Json counts_of(MockBench& b) {
    const ConverterCounts d = b.dac().counts();
    const IiodCounts a = b.accelerometer().counts();
    Json j{{"dac",
            {{"frames", d.frames},
             {"streams", d.streams},
             {"underruns", d.underruns},
             {"replayed", d.replayed},
             {"missed", d.missed},
             {"pulses_left_out", b.pulses_left_out()},
             {"timeline", b.dac().taken()},
             {"stream_starts", b.dac().stream_starts()}}},
           {"accelerometer",
            {{"pushed", a.pushed},
             {"dropped", a.dropped},
             {"unheard", a.unheard},
             {"served", a.served},
             {"overflowed", a.overflowed},
             {"unread", a.unread},
             {"connections", a.connections}}}};
    for (const std::string& name : b.camera_names()) {
        const GigeCounts c = b.camera(name).counts();
        j["camera"][name] = {{"pushed", c.pushed},   {"transmitted", c.transmitted}, {"damaged", c.damaged},
                             {"dropped", c.dropped}, {"overflow", c.overflow},       {"unasked", c.unasked}};
    }
    return j;
}

const Actions<MockBench>& questions() {
    static const Actions<MockBench> actions{
        {"counts",
         {"", "numbers sent and lost by every device",
          [](MockBench& b, Words&, Json& answer) { answer["counts"] = counts_of(b); }}},
        {"drift",
         {"STREAM FROM TO", "the walker's true v_D between times (s) after the stream's first trigger pulse",
          [](MockBench& b, Words& w, Json& answer) {
              const std::uint64_t stream = w.count("STREAM");
              const double from = w.number("FROM", experiment_s), to = w.number("TO", experiment_s);
              const double v = b.drift(stream, from, to);
              answer["v_D_mps"] = std::isfinite(v) ? Json(v) : Json(nullptr);
          }}}};
    return actions;
}

template <class Device>
void act(const Actions<Device>& actions, Device& device, const std::string& word, Words& words, Json& answer,
         const char* otherwise = "") {
    const auto found = actions.find(word);
    if (found == actions.end()) {
        std::string known = otherwise;
        for (const auto& [name, action] : actions) known += (known.empty() ? "" : ", ") + name;
        words.fail("\"" + word + "\" is not understood; expected one of " + known);
    }
    found->second.act(device, words, answer);
}

template <class Device>
std::string help(const std::string& before, const Actions<Device>& actions) {
    std::string text;
    for (const auto& [name, action] : actions)
        text += fmt::format("  {:<33} {}\n", fmt::format("{}{} {}", before, name, action.arguments),
                            action.meaning);
    return text;
}

}  // namespace

std::string bench_help() {
    return help("dac ", dac_actions()) + help("accelerometer ", accelerometer_actions()) +
           help("camera NAME ", camera_actions()) + help("", questions()) + "  quit\n";
}

std::string bench_command(MockBench& bench, const std::string& line) {
    constexpr const char* fault = "what shall go wrong";
    Words words{line};
    Json answer{{"ok", true}};
    const std::string first = words.next("a command");
    if (first == "dac") {
        act(dac_actions(), bench.dac(), words.next(fault), words, answer);
    } else if (first == "accelerometer") {
        act(accelerometer_actions(), bench.accelerometer(), words.next(fault), words, answer);
    } else if (first == "camera") {
        GigeCamera& camera = bench.camera(words.next("the camera's name"));
        act(camera_actions(), camera, words.next(fault), words, answer);
    } else {
        act(questions(), bench, first, words, answer, "accelerometer, camera, dac");
    }
    words.finish();
    return answer.dump();
}

}  // namespace shaker::mock
