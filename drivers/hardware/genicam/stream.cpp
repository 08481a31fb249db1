#include "drivers/hardware/genicam/stream.hpp"

#include <arv.h>

#include <algorithm>
#include <atomic>
#include <ctime>
#include <functional>
#include <utility>

#include "drivers/errors.hpp"
#include "drivers/lent_priority.hpp"
#include "drivers/realtime.hpp"

namespace shaker::genicam {

namespace {

// Buffer of the kernel for the time in which the receiving thread is delayed. Aravis' "auto" holds one
// picture; a delay of 40 ms would lose the next ones.
constexpr double socket_seconds = 0.25;
constexpr std::size_t socket_least = 1u << 18, socket_most = 1u << 26;  // bytes

std::int64_t clock_ns(clockid_t clock) noexcept {
    timespec t{};
    clock_gettime(clock, &t);
    return std::int64_t{t.tv_sec} * 1'000'000'000 + t.tv_nsec;
}

/// Aravis stamps arrivals with the time of day, which can be set. Both clocks are read here shortly after.
HostTime host_time(std::uint64_t realtime_ns) noexcept {
    const std::int64_t before = clock_ns(CLOCK_MONOTONIC);
    const std::int64_t realtime = clock_ns(CLOCK_REALTIME);
    const std::int64_t after = clock_ns(CLOCK_MONOTONIC);
    const std::int64_t age = realtime - static_cast<std::int64_t>(realtime_ns);
    return HostTime{std::chrono::nanoseconds{before + (after - before) / 2 - age}};
}

void on_control_lost(ArvDevice*, gpointer flag) { static_cast<std::atomic<bool>*>(flag)->store(true); }

struct Unref {
    void operator()(gpointer object) const noexcept { g_object_unref(object); }
};

}  // namespace

PictureBuffers::PictureBuffers(const GenicamPicture& picture, std::size_t queued, std::size_t given)
    : format_{picture.format},
      direct_{picture.format->packing == Packing::none && !picture.chunks},
      depth_{queued},
      pool_{static_cast<int>(direct_ ? queued + given : given), picture.width, picture.height,
            picture.format->bytes_per_pixel()},
      slots_(direct_ ? queued + given : queued) {
    for (Slot& slot : slots_) {
        if (direct_)
            slot.frame = pool_.acquire();
        else
            slot.wire.resize(picture.payload_bytes);
        slot.memory = slot.frame.get();
    }
    std::ranges::sort(slots_, std::less<>{}, &Slot::memory);
    for (Slot& slot : slots_) {
        std::vector<std::byte>& memory = direct_ ? slot.frame->pixels : slot.wire;
        slot.buffer = arv_buffer_new_full(memory.size(), memory.data(), &slot, nullptr);
        slot.frame.reset();
    }
}

PictureBuffers::~PictureBuffers() {
    for (const Slot& slot : slots_) g_object_unref(slot.buffer);
}

PictureBuffers::Slot& PictureBuffers::slot_of(ArvBuffer* buffer) noexcept {
    return *static_cast<Slot*>(const_cast<void*>(arv_buffer_get_user_data(buffer)));
}

void PictureBuffers::push(Slot& slot, ArvStream* stream) {
    slot.queued = true;
    ++queued_;
    arv_stream_push_buffer(stream, ARV_BUFFER(g_object_ref(slot.buffer)));
}

void PictureBuffers::queue(ArvStream* stream) {
    if (!direct_) {
        if (queued_ == slots_.size()) return;
        for (Slot& slot : slots_)
            if (!slot.queued) push(slot, stream);
        return;
    }
    while (queued_ < depth_) {
        std::shared_ptr<Frame> frame = pool_.acquire();
        if (frame == nullptr) return;
        const auto slot = std::ranges::lower_bound(slots_, frame.get(), std::less<>{}, &Slot::memory);
        slot->frame = std::move(frame);
        push(*slot, stream);
    }
}

std::shared_ptr<Frame> PictureBuffers::take(ArvBuffer* buffer) {
    Slot& slot = slot_of(buffer);
    std::shared_ptr<Frame> frame = direct_ ? std::move(slot.frame) : pool_.acquire();
    if (frame != nullptr && !direct_) unpack_pixels(*format_, slot.wire, frame->pixels);
    discard(buffer);
    return frame;
}

void PictureBuffers::discard(ArvBuffer* buffer) noexcept {
    Slot& slot = slot_of(buffer);
    slot.frame.reset();
    slot.queued = false;
    --queued_;
    g_object_unref(buffer);
}

void PictureBuffers::reclaim() noexcept {
    for (Slot& slot : slots_) {
        slot.frame.reset();
        slot.queued = false;
    }
    queued_ = 0;
}

struct GenicamStream::State {
    std::atomic<bool> control_lost = false;  // outlives the camera, whose thread sets it
    std::atomic<bool> receiving = false;     // the receiving thread has set `refused`
    std::string refused{};                   // real-time settings that were refused
    std::optional<LentPriority> priority{};  // the receiving thread's own
    GenicamSettings settings;
    std::string name;
    GenicamPicture picture{};
    std::vector<std::string> granted{};
    CameraHandle camera{};
    std::unique_ptr<ArvChunkParser, Unref> chunks{};
    std::unique_ptr<ArvStream, Unref> stream{};
    PictureBuffers* buffers = nullptr;

    State(const GenicamSettings& s, std::string n) : settings{s}, name{std::move(n)} {}

    [[noreturn]] void fail(const std::string& what, GError* error) {
        const std::string words = error != nullptr ? error->message : "no reason given";
        g_clear_error(&error);
        throw DeviceError{"camera \"" + name + "\" (" + settings.id + "): " + what + ": " + words};
    }

    static void on_stream(void* self, ArvStreamCallbackType type, ArvBuffer*) {
        auto& state = *static_cast<State*>(self);
        if (type == ARV_STREAM_CALLBACK_TYPE_EXIT) state.priority.reset();
        if (type != ARV_STREAM_CALLBACK_TYPE_INIT) return;
        static_cast<void>(name_thread("gvsp-" + state.name.substr(0, 10)));
        state.priority.emplace(pthread_self(), fifo_priority::picture_receiver);
        state.refused = state.priority->refused();
        state.receiving = true;
    }

    void open_stream() {
        GError* error = nullptr;
        stream.reset(arv_camera_create_stream(camera.get(), on_stream, this, &error));
        if (error != nullptr || stream == nullptr) fail("cannot create a stream", error);
        if (receiving && !refused.empty()) granted.push_back("receiving thread: " + refused);
        if (!ARV_IS_GV_STREAM(stream.get())) return;
        const double wanted =
            socket_seconds * settings.frame_rate_hz * 2.0 * static_cast<double>(picture.payload_bytes);
        const auto bytes = static_cast<std::size_t>(
            std::clamp(wanted, static_cast<double>(socket_least), static_cast<double>(socket_most)));
        g_object_set(stream.get(), "socket-buffer", ARV_GV_STREAM_SOCKET_BUFFER_FIXED, "socket-buffer-size",
                     static_cast<gint>(bytes), nullptr);
    }

    bool is_whole(ArvBuffer* buffer) const {
        std::size_t bytes = 0;
        arv_buffer_get_data(buffer, &bytes);
        if (arv_buffer_get_status(buffer) != ARV_BUFFER_STATUS_SUCCESS || bytes != picture.payload_bytes)
            return false;
        if (arv_buffer_get_payload_type(buffer) == ARV_BUFFER_PAYLOAD_TYPE_CHUNK_DATA) return true;
        return arv_buffer_get_image_width(buffer) == picture.width &&
               arv_buffer_get_image_height(buffer) == picture.height;
    }

    hardware::ExposureSign sign_of(ArvBuffer* buffer) {
        hardware::ExposureSign sign;
        sign.arrived = host_time(arv_buffer_get_system_timestamp(buffer));
        sign.id = arv_buffer_get_frame_id(buffer);
        if (picture.stamped)
            sign.stamp = CameraStamp{static_cast<std::int64_t>(arv_buffer_get_timestamp(buffer))};
        if (chunks != nullptr && arv_buffer_has_chunks(buffer) != FALSE) {
            if (const auto stamp = chunk(buffer, "ChunkTimestamp"); stamp && !picture.stamped)
                sign.stamp = CameraStamp{*stamp};
            if (const auto id = chunk(buffer, "ChunkFrameID")) sign.id = static_cast<std::uint64_t>(*id);
        }
        return sign;
    }

    std::optional<std::int64_t> chunk(ArvBuffer* buffer, const char* feature) {
        GError* error = nullptr;
        const std::int64_t value = arv_chunk_parser_get_integer_value(chunks.get(), buffer, feature, &error);
        if (error == nullptr) return value;
        g_error_free(error);
        return {};
    }
};

GenicamStream::GenicamStream(const GenicamSettings& settings, const std::string& name)
    : state_{std::make_unique<State>(settings, name)} {
    State& s = *state_;
    s.camera = open_genicam(settings, name, s.picture, s.granted);
    ArvDevice* const device = arv_camera_get_device(s.camera.get());
    g_signal_connect(device, "control-lost", G_CALLBACK(on_control_lost), &s.control_lost);
    if (s.picture.chunks) s.chunks.reset(arv_camera_create_chunk_parser(s.camera.get()));
}

GenicamStream::~GenicamStream() {
    State& s = *state_;
    if (s.stream != nullptr && !s.control_lost) arv_camera_stop_acquisition(s.camera.get(), nullptr);
    s.stream.reset();
    if (s.buffers != nullptr) s.buffers->reclaim();
}

const GenicamPicture& GenicamStream::picture() const noexcept { return state_->picture; }
const std::vector<std::string>& GenicamStream::granted() const noexcept { return state_->granted; }
void GenicamStream::forsake() noexcept { state_->control_lost = true; }
bool GenicamStream::control_lost() const noexcept { return state_->control_lost; }

void GenicamStream::start(PictureBuffers& buffers) {
    State& s = *state_;
    s.open_stream();
    s.buffers = &buffers;
    buffers.queue(s.stream.get());
    GError* error = nullptr;
    arv_camera_start_acquisition(s.camera.get(), &error);
    if (error != nullptr) s.fail("cannot start acquisition", error);
}

std::optional<ReceivedPicture> GenicamStream::receive(std::chrono::microseconds wait) {
    State& s = *state_;
    s.buffers->queue(s.stream.get());
    ArvBuffer* const buffer =
        wait.count() > 0 ? arv_stream_timeout_pop_buffer(s.stream.get(), static_cast<guint64>(wait.count()))
                         : arv_stream_try_pop_buffer(s.stream.get());
    if (buffer == nullptr) return {};
    ReceivedPicture received;
    received.whole = s.is_whole(buffer);
    if (received.whole) {
        received.sign = s.sign_of(buffer);
        received.frame = s.buffers->take(buffer);
    } else {
        s.buffers->discard(buffer);
    }
    return received;
}

bool GenicamStream::trigger() noexcept {
    GError* error = nullptr;
    arv_camera_software_trigger(state_->camera.get(), &error);
    const bool answered = error == nullptr;
    g_clear_error(&error);
    return answered;
}

}  // namespace shaker::genicam
