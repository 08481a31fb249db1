#pragma once
// What a recording has places for: every group and data set is made before the first sample, because a file
// that others read while it grows takes no new objects.
#include <cstddef>
#include <map>
#include <string>
#include <vector>

namespace shaker {

/// A data set of a recording.
struct Place {
    enum class Kind {
        number,   // one, 64-bit float; NaN until it is known
        text,     // one, fixed length; empty until it is known
        numbers,  // a column that grows, 64-bit float
        texts,    // likewise, fixed length
    };
    std::string name;
    std::string units;  // UDUNITS text; of a text: empty
    Kind kind = Kind::numbers;
    std::size_t text_bytes = 0;  // the longest text
    bool provisional = false;    // its rows are replaced when the recording is completed: not under seal
};

/// A group under /entry with what is in it.
struct GroupLayout {
    std::string path;
    std::string nx_class = "NXcollection";
    std::map<std::string, std::string> attributes;  // "signal", "axes", "title"
    std::vector<Place> places;
    double rows_per_s = 0;  // about, of its columns: 0 when there are few
};

/// A column of a table: its name, its unit as UDUNITS text, and its values.
struct Column {
    std::string name;
    std::string units;
    std::vector<double> values;
};

}  // namespace shaker
