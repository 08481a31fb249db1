// shaker-mock: a bench of mock devices that speak the real protocols, with faults on command.
#include <spdlog/fmt/fmt.h>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <exception>
#include <functional>
#include <iostream>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>

#include "drivers/errors.hpp"
#include "drivers/quantity.hpp"
#include "drivers/text/printable.hpp"
#include "tests/mock/loopback.hpp"
#include "tests/mock/mock_bench.hpp"

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
    const IiodCounts a = b.has_line_input() ? IiodCounts{} : b.accelerometer().counts();
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
         {"STREAM FROM TO FREQUENCY",
          "the walker's true v_D between times (s) after the stream's first trigger pulse",
          [](MockBench& b, Words& w, Json& answer) {
              const std::uint64_t stream = w.count("STREAM");
              const double from = w.number("FROM", experiment_s), to = w.number("TO", experiment_s);
              const double v = b.drift(stream, from, to, w.number("FREQUENCY", {1, 1000}));
              answer["v_D_mps"] = std::isfinite(v) ? Json(v) : Json(nullptr);
          }}}};
    return actions;
}

const Actions<LineInput>& line_actions() {
    static const Actions<LineInput> actions{
        {"overrun",
         {"", "the stream stops as after an overrun",
          [](LineInput& l, Words&, Json&) { l.cause_overrun(); }}},
        {"unplug", {"", "the input disappears", [](LineInput& l, Words&, Json&) { l.unplug(); }}},
        {"plug", {"", "the input returns", [](LineInput& l, Words&, Json&) { l.plug(); }}}};
    return actions;
}

const Actions<MockMixer>& mixer_actions() {
    static const Actions<MockMixer> actions{
        {"volume",
         {"VALUE", "another program sets the playback volume, 0 to 255", [](MockMixer& m, Words& w, Json&) {
              m.set_volume(std::lround(w.number("VALUE", {0, 255})));
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

/// Help: all commands, one per line.
std::string bench_help() {
    return help("dac ", dac_actions()) + help("accelerometer ", accelerometer_actions()) +
           help("camera NAME ", camera_actions()) + help("line ", line_actions()) +
           help("mixer ", mixer_actions()) + help("", questions()) + "  quit\n";
}

/// Executes a line and returns the answer as one JSON object: {"ok": true}, with "v_D_mps" or "counts" if
/// requested. Throws InputError that names the word not understood, DeviceError when a device refuses.
std::string bench_command(MockBench& bench, const std::string& line) {
    constexpr const char* fault = "what shall go wrong";
    Words words{line};
    Json answer{{"ok", true}};
    const std::string first = words.next("a command");
    if (first == "dac") {
        act(dac_actions(), bench.dac(), words.next(fault), words, answer);
    } else if (first == "accelerometer") {
        act(accelerometer_actions(), bench.accelerometer(), words.next(fault), words, answer);
    } else if (first == "line") {
        act(line_actions(), bench.line_input(), words.next(fault), words, answer);
    } else if (first == "mixer") {
        act(mixer_actions(), bench.mixer(), words.next(fault), words, answer);
    } else if (first == "camera") {
        GigeCamera& camera = bench.camera(words.next("the camera's name"));
        act(camera_actions(), camera, words.next(fault), words, answer);
    } else {
        act(questions(), bench, first, words, answer, "accelerometer, camera, dac, line, mixer");
    }
    words.finish();
    return answer.dump();
}

}  // namespace

}  // namespace shaker::mock

namespace {

using namespace shaker;
using namespace shaker::mock;

constexpr const char* about =
    "shaker-mock plays a whole bench: a DAC for libasound, an accelerometer for libiio and two GigE Vision\n"
    "cameras, all on one simulated shaker. It prints the rig file to give to shakerd, then obeys its "
    "input.\n";

// In memory, so that no disk is between the DAC and its client.
class Folder {
public:
    explicit Folder(const std::filesystem::path& asked) : path_{asked}, ours_{asked.empty()} {
        if (!ours_) {
            std::filesystem::create_directories(path_);
            return;
        }
        const std::filesystem::path memory{"/dev/shm"};
        const auto parent =
            std::filesystem::is_directory(memory) ? memory : std::filesystem::temp_directory_path();
        std::string name = (parent / "shaker-mock-XXXXXX").string();
        if (::mkdtemp(name.data()) == nullptr) throw DeviceError{name + ": " + std::strerror(errno)};
        path_ = name;
    }
    ~Folder() {
        std::error_code ignored;
        if (ours_) std::filesystem::remove_all(path_, ignored);
    }
    Folder(const Folder&) = delete;
    Folder& operator=(const Folder&) = delete;
    [[nodiscard]] const std::filesystem::path& path() const noexcept { return path_; }

private:
    std::filesystem::path path_;
    bool ours_;
};

void say(const nlohmann::json& answer) {
    std::cout << answer.dump(-1, ' ', true, nlohmann::json::error_handler_t::replace) << std::endl;
}

void obey(MockBench& bench) {
    for (std::string line; std::getline(std::cin, line);) {
        if (line.find_first_not_of(" \t") == std::string::npos) continue;
        if (line == "quit") return;
        try {
            std::cout << printable(bench_command(bench, line)) << std::endl;
        } catch (const std::exception& e) {
            say({{"ok", false}, {"error", e.what()}});
        }
    }
}

int serve(int argc, char** argv) {
    CLI::App app{about, "shaker-mock"};
    std::filesystem::path scene, folder;
    MockBenchSettings settings;
    app.add_option("--scene", scene,
                   "TOML file that changes the simulated bench (as for shakerd run --scene)");
    app.add_option("--dac-ppm", settings.dac_ppm, "Error of the DAC's clock in ppm; positive: fast")
        ->check(CLI::Range(-1000.0, 1000.0));
    app.add_option("--port", settings.iiod_port, "TCP port of the accelerometer's daemon [any free port]");
    app.add_option("--folder", folder, "Folder of the rig file and its data [a new one in memory]");
    app.add_flag("--line-input", settings.line_input,
                 "The accelerometer is analog, on the card's input, at the scene's accelerometer.rate_hz");
    app.add_option(
        "--cable", settings.cable,
        "With --line-input: a cable of this gain from output to input, in place of shaker and sensor");
    app.add_flag("--log-codes", settings.log_codes,
                 "Write every output sample to the file codes in the folder");
    app.footer("Commands on standard input, answered by a line of JSON each:\n" + bench_help());
    try {
        app.parse(argc, argv);
    } catch (const CLI::ParseError& e) {
        return app.exit(e) == 0 ? 0 : 2;
    }
    if (!scene.empty()) settings.scene = simulated::read_scene(scene);
    const std::array<std::string, 1> second{bench_addresses[1]};
    if (const std::string refused = add_loopback_addresses(second); !refused.empty())
        throw DeviceError{"the loopback interface: " + refused +
                          "; run \"sudo ip address add 127.0.0.2/8 dev lo\", or start shaker-mock and "
                          "shakerd from one \"unshare -rn\" shell"};
    settings.plugin = std::filesystem::read_symlink("/proc/self/exe").parent_path() / "shaker_mock_pcm.so";
    const Folder own{folder};
    settings.folder = own.path();
    MockBench bench{settings};
    say({{"ok", true}, {"rig", bench.rig_file().string()}});
    spdlog::info("the bench is running; try: shakerd check --rig {}", bench.rig_file().string());
    obey(bench);
    return 0;
}

}  // namespace

int main(int argc, char** argv) try {
    spdlog::set_default_logger(spdlog::stderr_color_mt("shaker-mock"));
    spdlog::set_pattern("%v");
    return serve(argc, argv);
} catch (const shaker::InputError& e) {
    spdlog::error("shaker-mock: {}", e.what());
    return 2;
} catch (const std::exception& e) {
    spdlog::error("shaker-mock: {}", e.what());
    return 3;
}
