#include "drivers/hardware/genicam/setup.hpp"

#include <arv.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "drivers/errors.hpp"

namespace shaker::genicam {
namespace {

/// Set-up of one camera: every call to Aravis goes through this class, so that no error is missed.
class Setup {
public:
    Setup(ArvCamera* camera, const GenicamSettings& asked, std::string who, std::vector<std::string>& granted)
        : camera_{camera}, asked_{asked}, who_{std::move(who)}, granted_{granted} {}

    GenicamPicture run();

private:
    [[noreturn]] void fail(const std::string& what) const { throw DeviceError{who_ + ": " + what}; }

    /// Calls `f` with a GError** and throws if it is set.
    template <class Function>
    auto call(const std::string& what, Function f) {
        GError* error = nullptr;
        const auto check = [&] {
            if (error == nullptr) return;
            const std::string words = error->message;
            g_error_free(error);
            fail(what + ": " + words);
        };
        if constexpr (std::is_void_v<decltype(f(&error))>) {
            f(&error);
            check();
        } else {
            const auto result = f(&error);
            check();
            return result;
        }
    }

    bool has(const char* feature) {
        return arv_camera_is_feature_available(camera_, feature, nullptr) != FALSE;
    }

    void set_pixel_format(GenicamPicture& picture) {
        guint n = 0;
        const char** names = arv_camera_dup_available_pixel_formats_as_strings(camera_, &n, nullptr);
        const std::vector<std::string> offered{names, names + n};
        g_free(static_cast<gpointer>(names));
        if (std::ranges::find(offered, asked_.pixel_format) == offered.end()) {
            std::string list;
            for (const std::string& name : offered) list += (list.empty() ? "" : ", ") + name;
            fail("pixel format " + asked_.pixel_format + " is not supported; the camera has " + list);
        }
        call("pixel format " + asked_.pixel_format, [&](GError** e) {
            arv_camera_set_pixel_format_from_string(camera_, asked_.pixel_format.c_str(), e);
        });
        picture.format = find_pixel_format(asked_.pixel_format);
        granted_.push_back("pixels " + asked_.pixel_format + ": 0 to " +
                           std::to_string(picture.format->full_scale()) + " in " +
                           std::to_string(8 * picture.format->bytes_per_pixel()) + " bits");
    }

    void set_region(GenicamPicture& picture) {
        std::array<int, 2> sensor{};
        call("sensor size",
             [&](GError** e) { arv_camera_get_sensor_size(camera_, &sensor[0], &sensor[1], e); });
        auto region = asked_.region_px;
        if (region[2] == 0) region = {0, 0, sensor[0], sensor[1]};
        const std::string text = region_text(region);
        for (std::size_t i = 0; i < 2; ++i) {
            if (region[i] + region[i + 2] > sensor[i])
                fail("region " + text + " exceeds its sensor of " + std::to_string(sensor[0]) + " x " +
                     std::to_string(sensor[1]) + " pixels");
        }
        require_step("width", region[2], arv_camera_get_width_increment(camera_, nullptr), sensor[0]);
        require_step("height", region[3], arv_camera_get_height_increment(camera_, nullptr), sensor[1]);
        call("region " + text, [&](GError** e) {
            arv_camera_set_region(camera_, region[0], region[1], region[2], region[3], e);
        });
        std::array<int, 4> got{};
        call("region",
             [&](GError** e) { arv_camera_get_region(camera_, &got[0], &got[1], &got[2], &got[3], e); });
        if (got != region) fail("region " + text + " is not granted; the camera set " + region_text(got));
        granted_.push_back("region " + text + " of " + std::to_string(sensor[0]) + " x " +
                           std::to_string(sensor[1]));
        picture.width = got[2];
        picture.height = got[3];
    }

    static std::string region_text(const std::array<int, 4>& r) {
        return std::to_string(r[2]) + " x " + std::to_string(r[3]) + " at " + std::to_string(r[0]) + ", " +
               std::to_string(r[1]);
    }

    void require_step(const std::string& what, int value, int step, int most) {
        if (step > 1 && value % step != 0)
            fail(what + " " + std::to_string(value) + " is not allowed: must be a multiple of " +
                 std::to_string(step) + " up to " + std::to_string(most));
    }

    void require_range(const std::string& what, double value, double min, double max,
                       const std::string& unit) {
        if (value < min || value > max)
            fail(what + " " + to_text(value) + unit + " is not allowed: must be " + to_text(Range{min, max}) +
                 unit);
    }

    void note_granted(const std::string& what, double got, double asked, const std::string& unit) {
        granted_.push_back(what + " " + to_text(got) + unit + " (requested " + to_text(asked) + ")");
    }

    void set_exposure(GenicamPicture& picture) {
        if (arv_camera_is_exposure_auto_available(camera_, nullptr) != FALSE)
            call("manual exposure",
                 [&](GError** e) { arv_camera_set_exposure_time_auto(camera_, ARV_AUTO_OFF, e); });
        double min = 0, max = 0;
        call("exposure", [&](GError** e) { arv_camera_get_exposure_time_bounds(camera_, &min, &max, e); });
        require_range("exposure", asked_.exposure_s, min / 1e6, max / 1e6, " s");
        call("exposure",
             [&](GError** e) { arv_camera_set_exposure_time(camera_, 1e6 * asked_.exposure_s, e); });
        picture.exposure_s =
            call("exposure", [&](GError** e) { return arv_camera_get_exposure_time(camera_, e); }) / 1e6;
        note_granted("exposure", picture.exposure_s, asked_.exposure_s, " s");
    }

    void set_gain() {
        if (arv_camera_is_gain_auto_available(camera_, nullptr) != FALSE)
            call("manual gain", [&](GError** e) { arv_camera_set_gain_auto(camera_, ARV_AUTO_OFF, e); });
        if (!asked_.gain) return;
        double min = 0, max = 0;
        call("gain", [&](GError** e) { arv_camera_get_gain_bounds(camera_, &min, &max, e); });
        require_range("gain", *asked_.gain, min, max, "");
        call("gain", [&](GError** e) { arv_camera_set_gain(camera_, *asked_.gain, e); });
        note_granted("gain", call("gain", [&](GError** e) { return arv_camera_get_gain(camera_, e); }),
                     *asked_.gain, "");
    }

    void set_trigger() {
        double min = 0, max = 0;
        call("frame rate", [&](GError** e) { arv_camera_get_frame_rate_bounds(camera_, &min, &max, e); });
        if (asked_.trigger == CameraTrigger::free) {
            require_range("frame rate", asked_.frame_rate_hz, min, max, " Hz");
            call("free run", [&](GError** e) { arv_camera_clear_triggers(camera_, e); });
            call("frame rate",
                 [&](GError** e) { arv_camera_set_frame_rate(camera_, asked_.frame_rate_hz, e); });
            const double got =
                call("frame rate", [&](GError** e) { return arv_camera_get_frame_rate(camera_, e); });
            note_granted("frame rate", got, asked_.frame_rate_hz, " Hz");
            return;
        }
        require_range("frame rate", asked_.frame_rate_hz, 0, max, " Hz");
        const std::string source = asked_.trigger == CameraTrigger::dac ? asked_.trigger_source : "Software";
        guint n = 0;
        const char** names = arv_camera_dup_available_trigger_sources(camera_, &n, nullptr);
        std::string list;
        bool found = false;
        for (guint i = 0; i < n; ++i) {
            list += (i == 0 ? "" : ", ") + std::string{names[i]};
            found = found || source == names[i];
        }
        g_free(static_cast<gpointer>(names));
        if (!found) fail("trigger source " + source + " is not supported; the camera has " + list);
        call("trigger from " + source,
             [&](GError** e) { arv_camera_set_trigger(camera_, source.c_str(), e); });
        granted_.push_back("trigger from " + source + ", " + to_text(asked_.frame_rate_hz) +
                           " Hz of at most " + to_text(max));
    }

    void set_ptp() {
        if (!asked_.ptp) return;
        const bool current = has("PtpEnable");
        const char* const feature = current ? "PtpEnable" : "GevIEEE1588";
        const char* const status = current ? "PtpStatus" : "GevIEEE1588Status";
        if (!has(feature)) {
            granted_.emplace_back("PTP: not supported by the camera (requested)");
            return;
        }
        call("PTP", [&](GError** e) { arv_camera_set_boolean(camera_, feature, TRUE, e); });
        const char* const words = has(status) ? arv_camera_get_string(camera_, status, nullptr) : nullptr;
        granted_.push_back(std::string{"PTP on, status "} + (words != nullptr ? words : "unknown"));
    }

    bool set_chunks() {
        if (arv_camera_are_chunks_available(camera_, nullptr) == FALSE) {
            if (asked_.chunks) granted_.push_back("chunks: not supported by the camera (requested)");
            return false;
        }
        if (!asked_.chunks) {
            call("chunks off", [&](GError** e) { arv_camera_set_chunk_mode(camera_, FALSE, e); });
            return false;
        }
        GError* error = nullptr;
        arv_camera_set_chunks(camera_, "FrameID,Timestamp", &error);
        if (error == nullptr) {
            granted_.emplace_back("chunks FrameID and Timestamp on");
            return true;
        }
        granted_.push_back(std::string{"chunks off: "} + error->message);
        g_error_free(error);
        arv_camera_set_chunk_mode(camera_, FALSE, nullptr);
        return false;
    }

    void set_transport(GenicamPicture& picture) {
        picture.wide_ids = arv_camera_is_gv_device(camera_) == FALSE;
        if (picture.wide_ids) return;
        arv_camera_gv_set_stream_options(camera_, ARV_GV_STREAM_OPTION_PACKET_SOCKET_DISABLED);
        arv_camera_gv_set_packet_size_adjustment(camera_, ARV_GV_PACKET_SIZE_ADJUSTMENT_NEVER);
        if (asked_.packet_bytes > 0)
            call("packet size",
                 [&](GError** e) { arv_camera_gv_set_packet_size(camera_, asked_.packet_bytes, e); });
        else
            call("packet size", [&](GError** e) { arv_camera_gv_auto_packet_size(camera_, e); });
        const guint bytes =
            call("packet size", [&](GError** e) { return arv_camera_gv_get_packet_size(camera_, e); });
        granted_.push_back("packets of " + std::to_string(bytes) + " bytes (requested " +
                           (asked_.packet_bytes > 0 ? std::to_string(asked_.packet_bytes) : "the largest") +
                           ")");
        auto* const device = ARV_GV_DEVICE(arv_camera_get_device(camera_));
        picture.stamped = arv_gv_device_get_timestamp_tick_frequency(device, nullptr) != 0;
        if (!picture.stamped) granted_.emplace_back("time stamps: the camera has no clock");
    }

    ArvCamera* camera_;
    const GenicamSettings& asked_;
    std::string who_;
    std::vector<std::string>& granted_;
};

GenicamPicture Setup::run() {
    GenicamPicture picture;
    arv_camera_set_range_check_policy(camera_, ARV_RANGE_CHECK_POLICY_ENABLE);
    arv_camera_stop_acquisition(camera_, nullptr);  // another program may have left it running
    set_pixel_format(picture);
    set_region(picture);
    set_exposure(picture);
    set_gain();
    set_trigger();
    set_ptp();
    picture.chunks = set_chunks();
    set_transport(picture);
    picture.payload_bytes =
        call("payload size", [&](GError** e) { return arv_camera_get_payload(camera_, e); });
    const std::size_t pixels = picture.format->wire_bytes(static_cast<std::size_t>(picture.width) *
                                                          static_cast<std::size_t>(picture.height));
    if (picture.payload_bytes < pixels)
        fail("its picture has " + std::to_string(picture.payload_bytes) + " bytes, expected " +
             std::to_string(pixels));
    return picture;
}

}  // namespace

void UnrefCamera::operator()(ArvCamera* camera) const noexcept { g_object_unref(camera); }

void log_lines_of_glib() {
    g_log_set_default_handler(
        [](const gchar* domain, GLogLevelFlags, const gchar* line, gpointer) {
            spdlog::debug("{}: {}", domain != nullptr ? domain : "aravis", line);
        },
        nullptr);
}

CameraHandle open_genicam(const GenicamSettings& settings, const std::string& name, GenicamPicture& picture,
                          std::vector<std::string>& granted) {
    const std::string who = "camera \"" + name + "\" (" + settings.id + ")";
    log_lines_of_glib();
    GError* error = nullptr;
    CameraHandle camera{arv_camera_new(settings.id.c_str(), &error)};
    if (camera == nullptr) {
        const std::string words = error != nullptr ? error->message : "not found";
        g_clear_error(&error);
        throw DeviceError{who + ": " + words};
    }
    ArvDevice* const device = arv_camera_get_device(camera.get());
    if (ARV_IS_GV_DEVICE(device) && arv_gv_device_is_controller(ARV_GV_DEVICE(device)) == FALSE)
        throw DeviceError{who + ": it is controlled by another program"};
    picture = Setup{camera.get(), settings, who, granted}.run();
    return camera;
}

}  // namespace shaker::genicam
