#include "drivers/mock/bench_commands.hpp"

#include <cmath>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>

#include "drivers/errors.hpp"
#include "drivers/quantity.hpp"

namespace shaker {

namespace {

using Json = nlohmann::ordered_json;

// The rest of a line, word by word.
class Words {
public:
    explicit Words(const std::string& line) : line_{line}, in_{line} {}

    std::string next(const char* expected) {
        std::string word;
        if (!(in_ >> word)) throw InputError{"\"" + line_ + "\": " + expected + " was expected at its end"};
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
            throw InputError{"\"" + line_ + "\": " + name + " = \"" + word +
                             "\" is not allowed: " + to_text(allowed) + " was expected"};
        return x;
    }
    std::uint64_t count(const char* name) { return static_cast<std::uint64_t>(number(name, {1, 1e9})); }
    std::int64_t nanoseconds(const char* name, Range allowed_s) {
        return std::llround(1e9 * number(name, allowed_s));
    }
    void finish() {
        std::string word;
        if (in_ >> word) throw InputError{"\"" + line_ + "\": \"" + word + "\" is too much"};
    }

private:
    std::string line_;
    std::istringstream in_;
};

constexpr Range duration_s{1e-3, 3600}, clock_s{-3600, 3600}, experiment_s{0, 1e6};

struct Action {
    const char* arguments;
    const char* meaning;
    std::function<void(Bench&, Words&, Json&)> act;
};
using Actions = std::map<std::string, Action>;

const Actions& dac_actions() {
    static const Actions actions{
        {"underrun",
         {"", "the stream stops, as if it had run dry",
          [](Bench& b, Words&, Json&) { b.dac().cause_underrun(); }}},
        {"stall",
         {"SECONDS", "playing stands still",
          [](Bench& b, Words& w, Json&) { b.dac().stall(Seconds{w.number("SECONDS", duration_s)}); }}},
        {"unplug", {"", "the device is gone", [](Bench& b, Words&, Json&) { b.dac().unplug(); }}},
        {"plug", {"", "it is back", [](Bench& b, Words&, Json&) { b.dac().plug(); }}}};
    return actions;
}

const Actions& accelerometer_actions() {
    static const Actions actions{
        {"silence",
         {"SECONDS", "nothing is sent, then all of it at once",
          [](Bench& b, Words& w, Json&) { b.accelerometer().silence(w.number("SECONDS", duration_s)); }}},
        {"freeze",
         {"SECONDS", "the last sample is repeated",
          [](Bench& b, Words& w, Json&) { b.accelerometer().freeze(w.number("SECONDS", duration_s)); }}},
        {"drop",
         {"SAMPLES", "the next samples are lost",
          [](Bench& b, Words& w, Json&) { b.accelerometer().drop(w.count("SAMPLES")); }}},
        {"disconnect",
         {"", "clients are cut off and may come back",
          [](Bench& b, Words&, Json&) { b.accelerometer().disconnect(); }}},
        {"error",
         {"ERRNO", "every open buffer ends with this error, e.g. -110",
          [](Bench& b, Words& w, Json&) {
              b.accelerometer().error(static_cast<int>(w.number("ERRNO", {-133, -1})));
          }}},
        {"shift",
         {"SECONDS", "the clock of the stamps jumps",
          [](Bench& b, Words& w, Json&) {
              b.accelerometer().shift_stamps(w.nanoseconds("SECONDS", clock_s));
          }}},
        {"jitter",
         {"SECONDS", "stamps are late in bursts, by up to this; 0 ends it", [](Bench& b, Words& w, Json&) {
              b.accelerometer().jitter_stamps(w.nanoseconds("SECONDS", {0, 1}));
          }}}};
    return actions;
}

// The camera's name comes first.
GigeCamera& camera(Bench& b, Words& w) { return b.camera(w.next("the camera's name")); }

const Actions& camera_actions() {
    static const Actions actions{
        {"lose",
         {"NAME SHARE", "each packet is lost with this probability; 0 ends it",
          [](Bench& b, Words& w, Json&) {
              GigeCamera& c = camera(b, w);
              c.lose(w.number("SHARE", {0, 1}));
          }}},
        {"stall",
         {"NAME SECONDS", "nothing is sent, then all of it at once",
          [](Bench& b, Words& w, Json&) {
              GigeCamera& c = camera(b, w);
              c.stall(w.number("SECONDS", duration_s));
          }}},
        {"drop",
         {"NAME FRAMES", "the next exposures are not sent",
          [](Bench& b, Words& w, Json&) {
              GigeCamera& c = camera(b, w);
              c.drop(w.count("FRAMES"));
          }}},
        {"shift",
         {"NAME SECONDS", "the clock of the stamps jumps",
          [](Bench& b, Words& w, Json&) {
              GigeCamera& c = camera(b, w);
              c.shift_stamps(w.nanoseconds("SECONDS", clock_s));
          }}},
        {"unplug", {"NAME", "the cable is pulled", [](Bench& b, Words& w, Json&) { camera(b, w).unplug(); }}},
        {"plug",
         {"NAME", "it is back, started afresh", [](Bench& b, Words& w, Json&) { camera(b, w).plug(); }}}};
    return actions;
}

Json counts_of(Bench& b) {
    const ConverterCounts d = b.dac().counts();
    const IiodCounts a = b.accelerometer().counts();
    Json j{{"dac",
            {{"frames", d.frames},
             {"streams", d.streams},
             {"underruns", d.underruns},
             {"replayed", d.replayed},
             {"missed", d.missed},
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

const std::map<std::string, Actions>& devices() {
    static const std::map<std::string, Actions> all{
        {"dac", dac_actions()}, {"accelerometer", accelerometer_actions()}, {"camera", camera_actions()}};
    return all;
}

const Actions& questions() {
    static const Actions actions{
        {"counts",
         {"", "what every device has sent and lost",
          [](Bench& b, Words&, Json& answer) { answer["counts"] = counts_of(b); }}},
        {"drift",
         {"STREAM FROM TO", "the walker's true v_D between times (s) after the stream's first trigger pulse",
          [](Bench& b, Words& w, Json& answer) {
              const std::uint64_t stream = w.count("STREAM");
              const double from = w.number("FROM", experiment_s), to = w.number("TO", experiment_s);
              const double v = b.drift(stream, from, to);
              answer["v_D_mps"] = std::isfinite(v) ? Json(v) : Json(nullptr);
          }}}};
    return actions;
}

const Action& find(const Actions& actions, const std::string& word, const std::string& line) {
    if (const auto found = actions.find(word); found != actions.end()) return found->second;
    std::string known;
    for (const auto& [name, action] : actions) known += (known.empty() ? "" : ", ") + name;
    throw InputError{"\"" + line + "\": \"" + word + "\" is not understood; one of " + known +
                     " was expected"};
}

}  // namespace

std::string bench_help() {
    std::string text;
    const auto add = [&](const std::string& device, const Actions& actions) {
        for (const auto& [name, action] : actions) {
            std::string left = "  " + device + name + " " + action.arguments;
            left.resize(std::max<std::size_t>(left.size() + 1, 36), ' ');
            text += left + action.meaning + "\n";
        }
    };
    for (const auto& [device, actions] : devices()) add(device + " ", actions);
    add("", questions());
    return text + "  quit\n";
}

std::string bench_command(Bench& bench, const std::string& line) {
    Words words{line};
    const std::string first = words.next("a command");
    Json answer{{"ok", true}};
    const auto device = devices().find(first);
    const Action& action = device != devices().end()
                               ? find(device->second, words.next("what shall go wrong"), line)
                               : find(questions(), first, line);
    action.act(bench, words, answer);
    words.finish();
    return answer.dump();
}

}  // namespace shaker
