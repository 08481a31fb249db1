#include "drivers/text/sha256.hpp"

#include <glib.h>

#include <memory>

namespace shaker::text {

std::string sha256(const std::string& text) {
    const std::unique_ptr<gchar, decltype(&g_free)> hex{
        g_compute_checksum_for_data(G_CHECKSUM_SHA256, reinterpret_cast<const guchar*>(text.data()),
                                    text.size()),
        &g_free};
    return hex.get();
}

}  // namespace shaker::text
