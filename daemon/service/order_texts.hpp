#pragma once
// Texts of orders: names and remarks that come from a network, and orders in words.
#include <string>

#include "daemon/service/bench_port.hpp"

namespace shaker::service {

/// A recording's name: 1 to 64 letters, digits, dots, hyphens and underscores, no dot in front. InputError
/// with the name otherwise.
void require_name(const std::string& what, const std::string& name);
/// A remark: 1 to 400 bytes of UTF-8 without control characters. InputError otherwise.
void require_remark(const std::string& text);

/// An order in words for the log: "set-point 20 Hz, gamma 1.5 g, rho 0.5, phi 35 deg". kind: "order" switches
/// the drive, "setting" does not. Orders of one kind and key are alike. An empty text is not logged: the
/// bench logs it itself.
struct OrderText {
    const char* kind = "order";
    std::string key{};
    std::string text = key;
};
OrderText words_of(const OrderWhat& what);

}  // namespace shaker::service
