vacuform_test(flattening_test
  SOURCES ${CMAKE_CURRENT_LIST_DIR}/flattening_test.cpp ${CMAKE_CURRENT_LIST_DIR}/flattening_methods_test.cpp
          ${CMAKE_CURRENT_LIST_DIR}/flattening_energy_test.cpp ${CMAKE_CURRENT_LIST_DIR}/flattening_solver_test.cpp
  LINKS vacuform_flattening)
