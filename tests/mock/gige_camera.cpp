#include "tests/mock/gige_camera.hpp"

#include <arpa/inet.h>
#include <arv.h>
#include <netinet/in.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <condition_variable>
#include <cstring>
#include <deque>
#include <mutex>
#include <optional>
#include <random>
#include <stop_token>
#include <thread>

#include "drivers/descriptor.hpp"
#include "drivers/errors.hpp"
#include "drivers/realtime.hpp"
#include "tests/mock/gige_features.hpp"
#include "tests/mock/gvsp.hpp"

namespace shaker::mock {
namespace {

using SteadyTime = std::chrono::steady_clock::time_point;
constexpr std::uint16_t gvcp_port = 3956;
constexpr std::uint32_t vendor_address = 0x48, model_address = 0x68;
constexpr const char* sources[] = {"Line0", "Line1", "Software"};

[[noreturn]] void fail(const GigeCameraSettings& s, const std::string& what) {
    throw DeviceError{"mock camera " + s.serial + " at " + s.address + ": " + what};
}

sockaddr_in socket_address(in_addr_t address, std::uint16_t port) {
    sockaddr_in result{};
    result.sin_family = AF_INET;
    result.sin_addr.s_addr = address;
    result.sin_port = htons(port);
    return result;
}

/// A UDP socket at the camera's address.
int bound_socket(const GigeCameraSettings& s, std::uint16_t port) {
    const int fd = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    if (fd < 0) fail(s, std::string{"no socket: "} + std::strerror(errno));
    const sockaddr_in address = socket_address(inet_addr(s.address.c_str()), port);
    if (bind(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) {
        const std::string why = std::strerror(errno);
        close(fd);
        fail(s, "UDP port " + std::to_string(port) + " cannot be used: " + why);
    }
    return fd;
}

/// Control channel, registers and description, served by a thread of Aravis' own.
class ControlChannel {
public:
    explicit ControlChannel(const GigeCameraSettings& s) {
        close(bound_socket(s, gvcp_port));  // Aravis only prints a warning when it is in use
        const std::string xml = gige_features_xml();
        const Descriptor file{memfd_create("genicam", MFD_CLOEXEC)};
        if (write(file, xml.data(), xml.size()) != static_cast<ssize_t>(xml.size()))
            fail(s, std::string{"no memory for the description: "} + std::strerror(errno));
        const std::string path = "/proc/self/fd/" + std::to_string(file);
        server_ = arv_gv_fake_camera_new_full(s.address.c_str(), s.serial.c_str(), path.c_str());
        if (arv_gv_fake_camera_is_running(server_) == FALSE) {
            g_object_unref(server_);
            fail(s, "the address is not an address of the loopback interface; add it");
        }
        camera_ = arv_gv_fake_camera_get_fake_camera(server_);
        write_text(vendor_address, "Shaker");
        write_text(model_address, "Mock");
        set(GigeRegister::sensor_width, s.width);
        set(GigeRegister::sensor_height, s.height);
        set(GigeRegister::width, s.width);
        set(GigeRegister::height, s.height);
        set(GigeRegister::pixel_format, 0x01080001);
        set(GigeRegister::frame_rate_mhz, 100000);
        set(GigeRegister::exposure_us, 1000);
        set(GigeRegister::ptp_status, 4);
    }
    ~ControlChannel() { g_object_unref(server_); }
    ControlChannel(const ControlChannel&) = delete;
    ControlChannel& operator=(const ControlChannel&) = delete;

    [[nodiscard]] std::uint32_t get(GigeRegister r, std::uint32_t index = 0) const {
        std::uint32_t value = 0;
        arv_fake_camera_read_register(camera_, static_cast<std::uint32_t>(r) + 4 * index, &value);
        return value;
    }
    void set(GigeRegister r, int value) {
        arv_fake_camera_write_register(camera_, static_cast<std::uint32_t>(r),
                                       static_cast<std::uint32_t>(value));
    }

private:
    void write_text(std::uint32_t address, std::string_view text) {
        std::array<char, 32> field{};
        text.copy(field.data(), field.size() - 1);
        arv_fake_camera_write_memory(camera_, address, field.size(), field.data());
    }

    ArvGvFakeCamera* server_ = nullptr;
    ArvFakeCamera* camera_ = nullptr;
};

/// One picture with the client's settings at the time of its exposure.
struct Shot {
    FramePtr frame;
    std::int64_t stamp_ns = 0;
    std::uint16_t id = 0;
    GigeRequest request;
    std::array<bool, std::size(gige_chunks)> chunks{};
    bool chunk_mode = false;
    std::size_t packet_bytes = 0;
    sockaddr_in client{};
};

GigeRequest request_of(const ControlChannel& c) {
    const auto number = [&](GigeRegister r) { return static_cast<int>(c.get(r)); };
    GigeRequest r;
    r.acquiring = c.get(GigeRegister::collector) != 0 && c.get(GigeRegister::control_privilege) != 0;
    r.triggered = c.get(GigeRegister::trigger_mode) != 0;
    r.source = sources[std::min<std::uint32_t>(c.get(GigeRegister::trigger_source), 2)];
    r.frame_rate_hz = 1e-3 * number(GigeRegister::frame_rate_mhz);
    r.exposure_s = 1e-6 * number(GigeRegister::exposure_us);
    r.gain_dB = 0.1 * number(GigeRegister::gain_tenths_db);
    r.region_px = {number(GigeRegister::x), number(GigeRegister::y), number(GigeRegister::width),
                   number(GigeRegister::height)};
    r.pixel_format = c.get(GigeRegister::pixel_format);
    r.ptp = c.get(GigeRegister::ptp_enable) != 0;
    r.stream_port = static_cast<std::uint16_t>(c.get(GigeRegister::stream_port));
    return r;
}

void append_chunk(const GigeChunk& chunk, std::uint64_t value, std::vector<std::byte>& out) {
    const auto put = [&](std::uint64_t number, int bytes) {
        for (int shift = 8 * (bytes - 1); shift >= 0; shift -= 8)
            out.push_back(static_cast<std::byte>(number >> shift));
    };
    put(value, chunk.bytes);
    put(chunk.id, 4);
    put(static_cast<std::uint64_t>(chunk.bytes), 4);
}

}  // namespace

struct GigeCamera::State {
    GigeCameraSettings settings;
    Descriptor stream;
    mutable std::mutex mutex{};
    mutable std::condition_variable_any changed{};
    std::optional<ControlChannel> control{};
    std::deque<Shot> queue{};  // exposed, waiting for transmission
    bool busy = false;         // the sender works on a picture
    GigeCounts counts{};
    double loss = 0;
    SteadyTime stalled_until{};
    std::uint64_t to_drop = 0;
    std::int64_t shift_ns = 0;
    std::uint64_t exposures = 0;  // since the camera was plugged
    std::minstd_rand random;
    std::jthread sender{};

    explicit State(const GigeCameraSettings& s) : settings{s}, stream{bound_socket(s, 0)}, random{s.seed} {
        control.emplace(s);
        sender = std::jthread{[this](const std::stop_token& stop) { run(stop); }};
    }

    void run(const std::stop_token& stop) {
        static_cast<void>(name_thread("mock-" + settings.serial.substr(0, 10)));
        std::unique_lock lock{mutex};
        while (!stop.stop_requested()) {
            if (queue.empty()) {
                changed.wait(lock, stop, [&] { return !queue.empty(); });
                continue;
            }
            if (std::chrono::steady_clock::now() < stalled_until) {
                changed.wait_until(lock, stop, stalled_until, [] { return false; });
                continue;
            }
            const Shot shot = std::move(queue.front());
            queue.pop_front();
            const double ratio = loss;
            busy = true;
            lock.unlock();
            const bool whole = transmit(shot, ratio);
            lock.lock();
            busy = false;
            ++(whole ? counts.transmitted : counts.damaged);
            changed.notify_all();
        }
    }

    void expose(FramePtr frame, std::int64_t stamp_ns) {
        ++counts.pushed;
        std::optional<Shot> shot = triggered();
        if (!shot) {
            ++counts.unasked;
            return;
        }
        shot->frame = std::move(frame);
        shot->stamp_ns = stamp_ns + shift_ns;
        shot->id = static_cast<std::uint16_t>((settings.first_id - 1u + exposures) % 65535 + 1);
        ++exposures;
        if (to_drop > 0) {
            --to_drop;
            ++counts.dropped;
        } else if (queue.size() >= settings.queue) {
            ++counts.overflow;
        } else {
            queue.push_back(std::move(*shot));
            changed.notify_all();
        }
    }

    /// Settings for sending a picture; empty when no client requested one.
    std::optional<Shot> triggered() {
        if (!control) return {};
        Shot shot;
        shot.request = request_of(*control);
        const auto& region = shot.request.region_px;
        const bool inside =
            region[0] + region[2] <= settings.width && region[1] + region[3] <= settings.height;
        if (!shot.request.acquiring || !inside) return {};
        if (shot.request.triggered && shot.request.source == "Software") {
            if (control->get(GigeRegister::trigger_software) == 0) return {};
            control->set(GigeRegister::trigger_software, 0);
        }
        shot.chunk_mode = control->get(GigeRegister::chunk_mode) != 0;
        for (std::uint32_t i = 0; i < shot.chunks.size(); ++i)
            shot.chunks[i] = control->get(GigeRegister::chunk_enable, i) != 0;
        shot.packet_bytes = control->get(GigeRegister::stream_packet) & 0xffff;
        shot.client =
            socket_address(htonl(control->get(GigeRegister::stream_address)), shot.request.stream_port);
        return shot;
    }

    /// False when a packet was lost.
    bool transmit(const Shot& shot, double ratio) {
        std::vector<std::byte> payload;
        const auto& region = shot.request.region_px;
        append_pixels(*shot.frame, region, shot.request.pixel_format, payload);
        const std::uint64_t values[] = {shot.id, static_cast<std::uint64_t>(shot.stamp_ns),
                                        static_cast<std::uint64_t>(1e6 * shot.request.exposure_s)};
        for (std::size_t i = 0; i < shot.chunks.size(); ++i)
            if (shot.chunk_mode && shot.chunks[i]) append_chunk(gige_chunks[i], values[i], payload);
        GvspBlock block{shot.id,
                        {shot.stamp_ns, shot.request.pixel_format, region[0], region[1], region[2], region[3],
                         shot.chunk_mode},
                        payload,
                        shot.packet_bytes};
        bool whole = true;
        std::uniform_real_distribution<double> chance{0, 1};
        for (std::size_t i = 0; i < block.packets(); ++i) {
            const auto packet = block.packet(i);
            const bool sent =
                (ratio == 0 || chance(random) >= ratio) &&
                sendto(stream, packet.data(), packet.size(), 0,
                       reinterpret_cast<const sockaddr*>(&shot.client), sizeof shot.client) >= 0;
            whole = whole && sent;
        }
        return whole;
    }
};

GigeCamera::GigeCamera(const GigeCameraSettings& settings) {
    if (settings.serial.empty() || settings.serial.size() > 15)
        throw InputError{"mock camera: serial \"" + settings.serial + "\" must have 1 to 15 characters"};
    if (settings.width < 4 || settings.height < 2 || settings.first_id == 0 || settings.queue == 0)
        throw InputError{"mock camera " + settings.serial +
                         ": width must be at least 4, height 2, first id 1, queue 1"};
    state_ = std::make_unique<State>(settings);
}

GigeCamera::~GigeCamera() = default;

void GigeCamera::push(FramePtr frame, std::int64_t stamp_ns) {
    State& s = *state_;
    if (frame == nullptr || frame->width != s.settings.width || frame->height != s.settings.height)
        throw InputError{"mock camera " + s.settings.serial + ": the picture is not " +
                         std::to_string(s.settings.width) + " x " + std::to_string(s.settings.height)};
    const std::scoped_lock lock{s.mutex};
    s.expose(std::move(frame), stamp_ns);
}

GigeRequest GigeCamera::requested() const {
    const std::scoped_lock lock{state_->mutex};
    return state_->control ? request_of(*state_->control) : GigeRequest{};
}

GigeCounts GigeCamera::counts() const {
    const std::scoped_lock lock{state_->mutex};
    return state_->counts;
}

bool GigeCamera::drained(double wait_s) const {
    std::unique_lock lock{state_->mutex};
    return state_->changed.wait_for(lock, std::chrono::duration<double>{wait_s},
                                    [&] { return state_->queue.empty() && !state_->busy; });
}

void GigeCamera::lose(double ratio) {
    const std::scoped_lock lock{state_->mutex};
    state_->loss = std::clamp(ratio, 0.0, 1.0);
}

void GigeCamera::stall(double seconds) {
    const std::scoped_lock lock{state_->mutex};
    state_->stalled_until =
        std::chrono::steady_clock::now() +
        std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::duration<double>{seconds});
}

void GigeCamera::drop(std::uint64_t n) {
    const std::scoped_lock lock{state_->mutex};
    state_->to_drop += n;
}

void GigeCamera::shift_stamps(std::int64_t ns) {
    const std::scoped_lock lock{state_->mutex};
    state_->shift_ns += ns;
}

void GigeCamera::unplug() {
    const std::scoped_lock lock{state_->mutex};
    state_->control.reset();
    state_->counts.dropped += state_->queue.size();
    state_->queue.clear();
}

void GigeCamera::plug() {
    const std::scoped_lock lock{state_->mutex};
    if (state_->control) return;
    state_->exposures = 0;
    state_->control.emplace(state_->settings);
}

}  // namespace shaker::mock
