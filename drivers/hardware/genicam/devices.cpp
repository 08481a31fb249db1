#include "drivers/hardware/genicam/devices.hpp"

#include <arv.h>

#include <memory>

#include "drivers/hardware/genicam/setup.hpp"

namespace shaker::genicam {
namespace {

std::string text(const char* words) { return words != nullptr ? words : ""; }

std::vector<std::string> texts(const char** words, guint n) {
    std::vector<std::string> result;
    for (guint i = 0; words != nullptr && i < n; ++i) result.emplace_back(words[i]);
    g_free(static_cast<gpointer>(words));
    return result;
}

void ask(GenicamDevice& device) {
    GError* error = nullptr;
    const CameraHandle camera{arv_camera_new(device.id.c_str(), &error)};
    if (camera != nullptr && error == nullptr)
        arv_camera_get_sensor_size(camera.get(), &device.sensor_width, &device.sensor_height, &error);
    if (camera != nullptr && error == nullptr)
        arv_camera_get_frame_rate_bounds(camera.get(), &device.rate_hz.min, &device.rate_hz.max, &error);
    if (camera != nullptr && error == nullptr) {
        guint n = 0;
        const char** names = arv_camera_dup_available_pixel_formats_as_strings(camera.get(), &n, &error);
        device.pixel_formats = texts(names, n);
    }
    if (camera != nullptr && error == nullptr) {
        guint n = 0;
        const char** names = arv_camera_dup_available_trigger_sources(camera.get(), &n, &error);
        device.trigger_sources = texts(names, n);
    }
    if (error != nullptr) device.trouble = error->message;
    if (camera == nullptr && error == nullptr) device.trouble = "no answer";
    g_clear_error(&error);
}

}  // namespace

std::vector<GenicamDevice> list_genicam_devices() {
    arv_update_device_list();
    std::vector<GenicamDevice> devices;
    for (unsigned i = 0; i < arv_get_n_devices(); ++i) {
        GenicamDevice device;
        device.id = text(arv_get_device_id(i));
        device.address = text(arv_get_device_address(i));
        device.vendor = text(arv_get_device_vendor(i));
        device.model = text(arv_get_device_model(i));
        device.serial = text(arv_get_device_serial_nbr(i));
        device.protocol = text(arv_get_device_protocol(i));
        devices.push_back(std::move(device));
    }
    for (GenicamDevice& device : devices) ask(device);
    return devices;
}

}  // namespace shaker::genicam
