#pragma once
/// What is inside a test's measurement, to be read or spoilt.

#include <downrange/est/model/measurement.hpp>

namespace downrange::test {

/// Of a plot.
inline Polar& polar(Measurement& m) { return std::get<Plot>(m.measured).measured; }
inline const Polar& polar(const Measurement& m) { return std::get<Plot>(m.measured).measured; }
/// Of a fix.
inline Fix& fix(Measurement& m) { return std::get<Fix>(m.measured); }
inline const Fix& fix(const Measurement& m) { return std::get<Fix>(m.measured); }

}  // namespace downrange::test
