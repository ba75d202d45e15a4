#pragma once
/// An experiment run twice: on other numbers of threads, say.

#include <gtest/gtest.h>

#include <cmath>

#include "experiment/report.hpp"

namespace downrange::test {

/// Every figure has the same value in both, is a number, and has a name that stands on one line with it.
inline void expect_same_figures(const experiment::ExperimentResult& one, const experiment::ExperimentResult& other) {
  ASSERT_EQ(one.figures.size(), other.figures.size());
  for (std::size_t i = 0; i < one.figures.size(); ++i) {
    const experiment::Figure& figure = one.figures[i];
    EXPECT_EQ(figure.measured, other.figures[i].measured) << figure.what;
    EXPECT_TRUE(std::isfinite(figure.measured)) << figure.what;
    EXPECT_LE(figure.what.size(), experiment::figure_name_width) << figure.what;
  }
}

}  // namespace downrange::test
