#pragma once

#include <string>

/// The begin of a warning, as two lines of at most 100 letters: its first clauses, which end with "; " or with the
/// text. Lists of edges are left out, numbers are rounded to six digits, and rules of the sign are options: "--sign
/// none". If clauses are left out, the text says how to see them.
std::string two_lines_of(const std::string& warning);
