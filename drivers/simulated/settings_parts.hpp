#pragma once
// One pass over the fields of a struct for reading and for writing: the visitor receives key, value and
// range.
#include <spdlog/fmt/fmt.h>

#include <initializer_list>
#include <string>
#include <string_view>
#include <type_traits>

#include "drivers/settings_table.hpp"

namespace shaker::simulated {

/// Reads the fields of a table. Missing keys keep their value.
struct ReadPart {
    SettingsTable table;
    void operator()(const char* key, double& x, Range r) { x = table.number(key, r, x); }
    void operator()(const char* key, int& x, Range r) {
        x = table.integer(key, static_cast<int>(r.min), static_cast<int>(r.max), x);
    }
    template <class Number>
    void unusual(const char* key, Number& x, Range r, std::type_identity_t<Number>) {
        (*this)(key, x, r);
    }
    void words(const char* key, std::string& x) { x = table.text(key, x); }
    template <class Choice>
    void choice(const char* key, Choice& x, std::initializer_list<std::string_view> names) {
        x = static_cast<Choice>(table.choice(key, names, static_cast<std::size_t>(x)));
    }
    template <class Choice>
    void unusual_choice(const char* key, Choice& x, std::initializer_list<std::string_view> names, Choice) {
        choice(key, x, names);
    }
};

/// Appends the fields as TOML that reads back exactly.
struct WritePart {
    std::string& text;
    void operator()(const char* key, double x, Range) const {
        text += fmt::format("{} = {}\n", key, number(x));
    }
    // Only a value that differs from the default: earlier versions read the text of a usual scene too.
    template <class Number>
    void unusual(const char* key, Number x, Range r, std::type_identity_t<Number> standard) const {
        if (x != standard) (*this)(key, x, r);
    }
    // Only where there are any; words have no single quotes and no line ends.
    void words(const char* key, const std::string& x) const {
        if (!x.empty()) text += fmt::format("{} = '{}'\n", key, x);
    }
    void operator()(const char* key, int x, Range) const { text += fmt::format("{} = {}\n", key, x); }
    template <class Choice>
    void choice(const char* key, Choice x, std::initializer_list<std::string_view> names) const {
        text += fmt::format("{} = \"{}\"\n", key, names.begin()[static_cast<std::size_t>(x)]);
    }
    template <class Choice>
    void unusual_choice(const char* key, Choice x, std::initializer_list<std::string_view> names,
                        Choice standard) const {
        if (x != standard) choice(key, x, names);
    }
    // The shortest exact text. TOML requires a point or an exponent in a floating-point number.
    static std::string number(double x) {
        std::string s = fmt::format("{}", x);
        return s.find_first_of(".e") == std::string::npos ? s + ".0" : s;
    }
};

}  // namespace shaker::simulated
