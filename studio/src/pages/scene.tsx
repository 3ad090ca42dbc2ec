export default function Page() { return <h1>scene</h1>; }
