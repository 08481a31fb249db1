#include "tests/mock/mock_bench.hpp"

#include <spdlog/fmt/fmt.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <atomic>
#include <cctype>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <fstream>
#include <iterator>
#include <limits>
#include <map>
#include <mutex>
#include <numbers>
#include <optional>
#include <random>
#include <stop_token>
#include <thread>
#include <utility>

#include "drivers/commissioned/record.hpp"
#include "drivers/errors.hpp"
#include "drivers/simulated/world.hpp"
#include "drivers/time.hpp"
#include "drivers/view_settings.hpp"

namespace shaker::mock {

namespace {

constexpr std::chrono::milliseconds pause{2};  // between polls of the converter
constexpr std::chrono::milliseconds patience{20};
constexpr std::int64_t largest_step = 960;  // samples, of the world
constexpr double camera_epoch_s = 1000;     // camera clock at the start of the bench

IiodDescription describe(const simulated::Scene& scene, const AccelerometerInfo& info) {
    IiodDescription d;
    d.rate_hz = scene.accelerometer.rate_hz;
    d.rates_hz = {d.rate_hz};
    d.mps2_per_count = info.mps2_per_count;
    d.bits = scene.accelerometer.bits;
    return d;
}

// Threads are declared last: they end before the objects they use.
struct MockCamera {
    Camera& device;  // of the world
    std::unique_ptr<GigeCamera> gige;
    double clock;                                                 // camera seconds per true second
    double next_free = std::numeric_limits<double>::quiet_NaN();  // sample of its next free-running exposure
    std::jthread thread{};
};

constexpr double period_s = 0.01, buffer_s = 0.2;  // a buffer longer than the pauses of a busy computer
constexpr double mv_per_g = 100, standard_gravity = 9.80665;  // of an analog sensor

double full_scale_V(const simulated::Scene& scene) {
    return 1e-3 * mv_per_g * scene.accelerometer.range_mps2 / standard_gravity;
}

constexpr double missing_s = 0.25, camera_missing_s = 1, watchdog_s = 2;

void write_text(const std::filesystem::path& file, const std::string& text) {
    std::ofstream out{file};
    out << text;
    out.close();
    if (!out) throw DeviceError{file.string() + ": " + std::strerror(errno)};
}

// Serial number of the mock camera for the scene's camera `name`; its id is Shaker-Mock-<serial>.
std::string bench_serial(const std::string& name) {
    std::string serial;
    for (const char c : name) serial += static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
    return serial;
}

// Writes libasound's configuration and a rig file into the settings' folder; returns the path of rig.toml.
std::filesystem::path write_bench_files(const MockBenchSettings& s, std::optional<std::uint16_t> iiod_port) {
    const std::filesystem::path config = s.folder / "asound.conf";
    std::filesystem::path rig = std::filesystem::absolute(s.folder / "rig.toml");
    const std::string plugin = std::filesystem::absolute(s.plugin).string();
    const std::string channels = s.channels > 0 ? fmt::format(" channels {}", s.channels) : "";
    write_text(config, fmt::format("pcm_type.shaker_mock {{ lib \"{0}\" }}\n"
                                   "pcm_type.shaker_mock_line {{ lib \"{0}\" }}\n"
                                   "pcm.shaker_mock {{ type shaker_mock converter \"{1}\"{4} }}\n"
                                   "pcm.shaker_line {{ type shaker_mock_line input \"{2}\"{4} }}\n"
                                   "ctl_type.shaker_mock_mixer {{ lib \"{0}\" }}\n"
                                   "ctl.shaker_card {{ type shaker_mock_mixer file \"{3}\" }}\n",
                                   plugin, std::filesystem::absolute(s.folder / "converter").string(),
                                   std::filesystem::absolute(s.folder / "line").string(),
                                   std::filesystem::absolute(s.folder / "mixer").string(), channels));
    const std::string sensor =
        iiod_port ? fmt::format(
                        "uri = \"ip:127.0.0.1:{}\"\ndevice = \"{}\"\nrate_hz = {}\nstamps = \"host\"\n"
                        "range_mps2 = {}\n",
                        *iiod_port, IiodDescription{}.name, s.scene.accelerometer.rate_hz,
                        s.scene.accelerometer.range_mps2)
                  : fmt::format(
                        "driver = \"alsa\"\npcm = \"shaker_line\"\nalsa_config = \"asound.conf\"\n"
                        "rate_hz = {:.0f}\nchannels = [1]\nclock = \"{}\"\nfull_scale_V = "
                        "{}\nsensitivity_mv_per_g = {}\n",
                        s.scene.accelerometer.rate_hz, s.scene.accelerometer.clock_ppm == 0 ? "dac" : "own",
                        full_scale_V(s.scene), mv_per_g);
    std::string text = fmt::format(
        "# The mock bench: valid while the shaker-mock that wrote it runs.\n"
        "real_time = \"wanted\"\n"
        "[dac]\npcm = \"shaker_mock\"\nalsa_config = \"asound.conf\"\nmixer = \"shaker_card\"\nrate_hz = "
        "{:.0f}\nformat = \"S32\"\n"
        "period_frames = {:.0f}\nbuffer_frames = {:.0f}\nfull_scale_V = {}\nsecond_channel = \"trigger\"\n\n"
        "[accelerometer]\n{}\n"
        "[limits]  # longer than on hardware, for busy computers\nmissing_s = {}\ncamera_missing_s = {}\n"
        "watchdog_s = {}\n\n{}",
        s.scene.dac_rate_hz, period_s * s.scene.dac_rate_hz, buffer_s * s.scene.dac_rate_hz,
        s.scene.dac_full_scale_v, sensor, missing_s, camera_missing_s, watchdog_s,
        shaker_text(s.scene.shaker));
    for (const simulated::CameraTruth& c : s.scene.cameras)
        text += fmt::format(
            "\n[[camera]]\ndriver = \"genicam\"\nid = \"Shaker-Mock-{}\"\ntrigger = \"dac\"\n"
            "arrival_delay_s = {}\n{}",
            bench_serial(c.view.camera), c.view.exposure_s + c.latency_s, view_text(c.view));
    write_text(rig, text);
    return rig;
}

}  // namespace

struct MockBench::State {
    explicit State(const MockBenchSettings& s);

    /// Host time for a time on the DAC's clock since the start of the bench, s.
    [[nodiscard]] double host_s(double dac_s) const { return dac_s / (1 + 1e-6 * settings.dac_ppm); }
    void play(const std::stop_token& stop);
    void play(std::span<const double> first, std::span<const double> second);
    void find_pulses(std::span<double> share);
    void warn_when_late();
    void send_samples();
    void send_to_line(const AccelBlock& block);
    void send_by_cable(std::span<const double> share);
    void send_pictures(const std::stop_token& stop, MockCamera& camera);
    std::int64_t until_free_exposure(std::int64_t most);

    MockBenchSettings settings;
    simulated::World world;
    Rig rig;
    Converter converter;
    std::unique_ptr<Iiod> iiod;  // one of both
    std::unique_ptr<LineInput> line;
    MockMixer mixer;
    std::vector<MockCamera> cameras;
    std::filesystem::path rig_file;
    double trigger_before = 0;
    bool warned_late = false;
    // Samples.
    const double spacing = settings.scene.dac_rate_hz / settings.scene.cameras[0].view.frame_rate_hz;
    std::int64_t last_pulse = -1;  // sample of the world
    std::atomic<std::uint64_t> pulses_left_out = 0;
    mutable std::mutex pulses;
    std::map<std::uint64_t, std::int64_t> first_pulse;  // of each stream: sample of the world
    std::int64_t played = 0;                            // samples of the world
    std::mt19937_64 random{1};
    double cable_in = 0, cable_out = 0;
    std::exponential_distribution<double> interrupt_s;
    std::jthread player;
};

MockBench::State::State(const MockBenchSettings& s)
    : settings{s},
      world{s.scene},
      rig{world.rig()},
      converter{s.folder / "converter", s.scene.dac_rate_hz, s.dac_ppm,
                s.log_codes ? s.folder / "codes" : std::filesystem::path{}},
      iiod{s.line_input ? nullptr
                        : std::make_unique<Iiod>(describe(s.scene, rig.accelerometer->info()), s.iiod_port)},
      line{s.line_input ? std::make_unique<LineInput>(s.folder / "line", s.scene.accelerometer.rate_hz,
                                                      s.scene.accelerometer.rate_hz *
                                                          (1 + 1e-6 * s.scene.accelerometer.clock_ppm) *
                                                          (1 + 1e-6 * s.dac_ppm),
                                                      converter.time_of(0))
                        : nullptr},
      mixer{s.folder / "mixer"},
      interrupt_s{1 / std::max(s.scene.accelerometer.latency_jitter_s, 1e-9)} {
    for (std::size_t i = 0; i < rig.cameras.size(); ++i) {
        const simulated::CameraTruth& c = s.scene.cameras.at(i);
        cameras.push_back(
            {.device = *rig.cameras[i],
             .gige = std::make_unique<GigeCamera>(GigeCameraSettings{.address = bench_addresses.at(i),
                                                                     .serial = bench_serial(c.view.camera),
                                                                     .width = c.width,
                                                                     .height = c.height,
                                                                     .seed = static_cast<unsigned>(i + 1)}),
             .clock = 1 + 1e-6 * s.camera_ppm.at(i)});
    }
    rig_file = write_bench_files(s, iiod ? std::optional{iiod->port()} : std::nullopt);
    const auto content = [](const std::filesystem::path& file) {
        std::ifstream in{file};
        return std::string{std::istreambuf_iterator<char>{in}, {}};
    };
    if (s.commissioned)
        commissioned::write_record(rig_file,
                                   {.date = "1970-01-01T00:00:00+00:00",
                                    .rig_sha256 = commissioned::rig_hash(content(rig_file)),
                                    .files = {{"alsa_config", content(s.folder / "asound.conf")},
                                              {"mixer of shaker_card",
                                               "iface=MIXER,name='Line 3/4 Playback Volume' = 200,200\n"
                                               "iface=MIXER,name='Line 3/4 Playback Switch' = 1\n"}},
                                    .items = {{"mock bench", "nothing can be harmed"}}});
    for (MockCamera& camera : cameras)
        camera.thread =
            std::jthread{[this, &camera](const std::stop_token& stop) { send_pictures(stop, camera); }};
    player = std::jthread{[this](const std::stop_token& stop) { play(stop); }};
}

// Real time by the converter's clock: takes the output samples and advances the world by them.
void MockBench::State::play(const std::stop_token& stop) {
    std::vector<double> first, second;
    while (!stop.stop_requested()) {
        std::this_thread::sleep_for(pause);
        for (std::int64_t due = converter.due(host_now()) - converter.taken(); due > 0; due -= largest_step) {
            const auto n = static_cast<std::size_t>(std::min(due, largest_step));
            first.resize(n);
            second.resize(n);
            converter.take(first, second);
            if (settings.cable != 0) send_by_cable(first);
            for (double& share : first) share *= settings.scene.dac_full_scale_v;
            warn_when_late();
            find_pulses(second);
            play(first, second);
            send_samples();
        }
    }
}

void MockBench::State::warn_when_late() {
    const std::uint64_t missed = converter.counts().missed;
    if (missed == 0 || std::exchange(warned_late, true)) return;
    spdlog::warn(
        "this computer is too slow for the mock bench: {} samples of the DAC were overwritten before the "
        "simulated world processed them; reduce the cameras' frame rate",
        missed);
}

// 1 where the trigger line rises, else 0.
void MockBench::State::find_pulses(std::span<double> share) {
    for (std::size_t i = 0; i < share.size(); ++i) {
        const bool rises = std::exchange(trigger_before, share[i]) <= 0.5 && share[i] > 0.5;
        share[i] = rises ? 1 : 0;
        if (!rises) continue;
        const std::int64_t sample = played + static_cast<std::int64_t>(i), apart = sample - last_pulse;
        if (last_pulse >= 0 && static_cast<double>(apart) < settings.scene.dac_rate_hz)
            pulses_left_out +=
                static_cast<std::uint64_t>(std::lround(static_cast<double>(apart) / spacing) - 1);
        last_pulse = sample;
        const std::uint64_t streams = converter.counts().streams;
        const std::scoped_lock lock{pulses};
        first_pulse.try_emplace(streams, sample);
    }
}

void MockBench::State::play(std::span<const double> first, std::span<const double> second) {
    while (!first.empty()) {
        const auto n = static_cast<std::size_t>(until_free_exposure(static_cast<std::int64_t>(first.size())));
        if (n > 0) rig.dac->write(first.first(n), second.first(n));
        played += static_cast<std::int64_t>(n);
        first = first.subspan(n);
        second = second.subspan(n);
    }
}

// Number of samples before the next exposure of a free-running camera; starts that exposure if it is due now.
std::int64_t MockBench::State::until_free_exposure(std::int64_t most) {
    for (std::size_t i = 0; i < cameras.size(); ++i) {
        MockCamera& camera = cameras[i];
        const GigeRequest asked = camera.gige->requested();
        if (!asked.acquiring || asked.triggered || !(asked.frame_rate_hz > 0)) {
            camera.next_free = NAN;
            continue;
        }
        const double step = settings.scene.dac_rate_hz / asked.frame_rate_hz / camera.clock;
        const auto here = static_cast<double>(played);
        if (std::isnan(camera.next_free)) camera.next_free = here + step;
        if (camera.next_free <= here) {
            world.expose_next(i);
            camera.next_free += step;
            most = std::min<std::int64_t>(most, 1);
        }
        most = std::min(most, static_cast<std::int64_t>(std::ceil(camera.next_free - here)));
    }
    return most;
}

// The cable's end is coupled by a capacitor, with the corner of the scene's sensor.
void MockBench::State::send_by_cable(std::span<const double> share) {
    const simulated::Scene& scene = settings.scene;
    const double gain = settings.cable * scene.dac_full_scale_v / full_scale_V(scene);
    const double t = std::tan(std::numbers::pi * scene.accelerometer.high_pass_hz / scene.dac_rate_hz);
    const double keep = (1 - t) / (1 + t);
    std::normal_distribution<double> noise{0, 1e-5};
    std::vector<std::array<std::int32_t, 2>> frames;
    for (const double x : share) {
        cable_out = keep * cable_out + 0.5 * (1 + keep) * (x - std::exchange(cable_in, x));
        const double heard = std::clamp(gain * cable_out + noise(random), -1.0, 1.0);
        frames.push_back({static_cast<std::int32_t>(std::lround(heard * 0x7fffff00)), 0});
    }
    line->put(frames);
}

// The first sample of the world comes start_s after the epoch, which nobody knows.
void MockBench::State::send_to_line(const AccelBlock& block) {
    std::array<std::array<std::int32_t, 2>, AccelBlock::capacity> frames{};
    const int left = 32 - settings.scene.accelerometer.bits;
    const auto n = static_cast<std::size_t>(block.size);
    for (std::size_t i = 0; i < n; ++i)
        for (std::size_t k = 0; k < frames[i].size(); ++k) frames[i][k] = block.counts[i][k] << left;
    line->put(std::span{frames}.first(n));
}

void MockBench::State::send_samples() {
    AccelBlock block;
    std::vector<IiodSample> samples;
    const simulated::AccelerometerTruth& a = settings.scene.accelerometer;
    const HostTime began = converter.time_of(0);
    while (rig.accelerometer->read(block, std::chrono::milliseconds{0})) {
        if (line) {
            if (settings.cable == 0) send_to_line(block);
            continue;
        }
        samples.clear();
        for (std::size_t i = 0; i < static_cast<std::size_t>(block.size); ++i) {
            const double converted_s = a.start_s + duration_s(block.first.n + static_cast<std::int64_t>(i),
                                                              a.rate_hz * (1 + 1e-6 * a.clock_ppm));
            const Seconds stamp{host_s(converted_s) + interrupt_s(random)};
            const HostTime at = began + std::chrono::duration_cast<std::chrono::nanoseconds>(stamp);
            samples.push_back({block.counts[i], at.time_since_epoch().count()});
        }
        iiod->push(samples);
    }
}

void MockBench::State::send_pictures(const std::stop_token& stop, MockCamera& camera) {
    const double half_exposure_s = 0.5 * camera.device.view().exposure_s;
    while (!stop.stop_requested()) {
        FramePtr frame = camera.device.read(patience);
        if (frame == nullptr) continue;
        const double start_s = seconds(*frame->mid_exposure) - half_exposure_s;
        const double stamp_s = camera_epoch_s + camera.clock * host_s(start_s);
        camera.gige->push(std::move(frame), std::llround(1e9 * stamp_s));
    }
}

MockBench::MockBench(const MockBenchSettings& settings) : state_{std::make_unique<State>(settings)} {}
MockBench::~MockBench() = default;

const std::filesystem::path& MockBench::rig_file() const noexcept { return state_->rig_file; }
Converter& MockBench::dac() noexcept { return state_->converter; }
Iiod& MockBench::accelerometer() {
    if (!state_->iiod) throw InputError{"accelerometer: the bench has an analog one, on the line input"};
    return *state_->iiod;
}
MockMixer& MockBench::mixer() noexcept { return state_->mixer; }
bool MockBench::has_line_input() const noexcept { return state_->line != nullptr; }
LineInput& MockBench::line_input() {
    if (!state_->line) throw InputError{"line: the bench has no line input; start it with --line-input"};
    return *state_->line;
}

GigeCamera& MockBench::camera(const std::string& name) {
    for (MockCamera& camera : state_->cameras)
        if (camera.device.view().camera == name) return *camera.gige;
    std::string there;
    for (const std::string& known : camera_names()) there += (there.empty() ? "\"" : ", \"") + known + "\"";
    throw InputError{"camera \"" + name + "\": no such camera; expected one of " + there};
}

std::vector<std::string> MockBench::camera_names() const {
    std::vector<std::string> names;
    for (const MockCamera& camera : state_->cameras) names.push_back(camera.device.view().camera);
    return names;
}

std::uint64_t MockBench::pulses_left_out() const { return state_->pulses_left_out; }

double MockBench::drift(std::uint64_t stream, double from_s, double to_s, double frequency_hz) const {
    const std::scoped_lock lock{state_->pulses};
    const auto found = state_->first_pulse.find(stream);
    if (found == state_->first_pulse.end()) return NAN;
    const double began_s = duration_s(found->second, state_->settings.scene.dac_rate_hz);
    return drift_velocity(state_->world.truth(0), began_s + from_s, began_s + to_s, frequency_hz);
}

}  // namespace shaker::mock
