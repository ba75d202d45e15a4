find_package(nlohmann_json REQUIRED)
downrange_test(experiment_test ${CMAKE_CURRENT_LIST_DIR}/experiment_test.cpp
               LIBS downrange_experiment nlohmann_json::nlohmann_json)
downrange_test(experiment_papers_test ${CMAKE_CURRENT_LIST_DIR}/experiment_papers_test.cpp LIBS downrange_experiment)
downrange_test(experiment_kim2011_test ${CMAKE_CURRENT_LIST_DIR}/experiment_kim2011_test.cpp LIBS downrange_experiment)
downrange_test(experiment_noise_test ${CMAKE_CURRENT_LIST_DIR}/experiment_noise_test.cpp LIBS downrange_experiment)
downrange_test(experiment_honesty_test ${CMAKE_CURRENT_LIST_DIR}/experiment_honesty_test.cpp LIBS downrange_experiment)
downrange_test(experiment_impact_test ${CMAKE_CURRENT_LIST_DIR}/experiment_impact_test.cpp LIBS downrange_experiment)
