// Everything a program that uses perp includes. Floor by floor, each built on those above it.
#pragma once

#include "perp/version.hpp"

#include "perp/core/errors.hpp"
#include "perp/core/pose.hpp"
#include "perp/core/types.hpp"

#include "perp/solve/friction_io.hpp"
#include "perp/solve/friction_problem.hpp"
#include "perp/solve/friction_residual.hpp"
#include "perp/solve/friction_solver.hpp"
#include "perp/solve/lcp.hpp"
#include "perp/solve/lemke.hpp"
#include "perp/solve/mixed_lcp.hpp"
#include "perp/solve/ncp.hpp"
#include "perp/solve/problem_io.hpp"

#include "perp/model/body.hpp"
#include "perp/model/force.hpp"
#include "perp/model/differentiable_gap.hpp"
#include "perp/model/gap.hpp"
#include "perp/model/gaps.hpp"
#include "perp/model/inertia.hpp"
#include "perp/model/joint.hpp"
#include "perp/model/model.hpp"
#include "perp/model/state.hpp"

#include "perp/instant/instant.hpp"

#include "perp/step/lcp_stepper.hpp"
#include "perp/step/methods.hpp"
#include "perp/step/ncp2_stepper.hpp"
#include "perp/step/ncp_stepper.hpp"
#include "perp/step/simulate.hpp"
#include "perp/step/stepper.hpp"
#include "perp/step/trajectory.hpp"

#include "perp/study/convergence.hpp"
#include "perp/study/cpu_time.hpp"
#include "perp/study/error_measure.hpp"
#include "perp/study/friction_families.hpp"
#include "perp/study/observed_order.hpp"
#include "perp/study/scene.hpp"
#include "perp/study/work_precision.hpp"

#include "perp/io/chart.hpp"
#include "perp/io/csv_file.hpp"
#include "perp/io/expression.hpp"
#include "perp/io/run_files.hpp"
#include "perp/io/scene_file.hpp"
#include "perp/io/study_files.hpp"
#include "perp/io/study_folder.hpp"
