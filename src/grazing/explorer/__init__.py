"""The explorer: the pictures of the paper in a browser, drawn by the same kernels, compiled to WebAssembly.

``gap`` and ``oscillator`` say which kernels are functions of a module, with their arguments; ``build`` compiles them to
``kernels/*.wasm`` and writes ``kernels/kernels.json``, which describes the functions and the parameters to a page.

How a function is called
------------------------
A module imports nothing. It exports ``memory``, the functions that kernels.json lists, ``__heap_base``, from where on
memory is free, and ``arena(address)``.

* First come the ``sizes``, whole numbers, then the ``arguments`` in their order: a number where ``shape`` is empty,
  else the address of an array. Whole numbers and addresses are 32 bits wide, other numbers float64.
* The caller chooses where arrays lie, at multiples of 8 (better of 64) from ``__heap_base`` on, grows the memory so
  that they fit, and calls ``arena(end of the last one)``: beyond, kernels put arrays of their own, and grow the memory
  themselves if need be, so views of it must be made again after a call. What is beyond is free again after each call.
* Arrays are without gaps, last index fastest; the sizes in ``shape`` are numbers or names of sizes or arguments. What a
  function writes is said in its arguments' meanings; ``outcomes`` is added to, so the caller begins with zeros.
* A call that cannot be completed (memory) traps, which in JavaScript is an exception; then call ``arena`` again.

The arithmetic is strict: every raster, orbit and class is that of the same study in Python with
``arithmetic="strict"``, bit for bit. One thing is left out: where double precision cannot decide between impact and no
impact, Python goes on in ball arithmetic. Here such starts are counted in ``ambiguous``.
"""
